"""A task file, checked and with every name and parameter resolved."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from config import Diagnostic, Location, Plain, UserError
from trees.language.documents import TaskOutput, TaskParameter
from trees.language.leaf_type import LeafType
from trees.language.values import Argument, KeyRead, KeyWrite
from trees.words import ASKING, COMPOSITES, CompositeWord, NamedValue, Outcomes

SCENE = "scene:"  # where a task names its scene, among its locations

Modifiers: TypeAlias = "Mapping[str, Plain | KeyRead | LeafNode | CompositeNode]"
"""Values by key, in the order in which they wrap, innermost first; that of a guard is a condition.

A `KeyRead` stands only in a task that was loaded with open parameters.
"""


@dataclass(frozen=True, kw_only=True)
class _Node:
    location: Location
    name: str
    modifiers: Modifiers = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class LeafNode(_Node):
    """A leaf and its arguments."""

    type: LeafType
    arguments: Mapping[str, Argument]
    """What the file gives; the leaf's own defaults are not filled in. Of `set`, keys and values."""
    outputs: Mapping[str, KeyWrite] = field(default_factory=dict)
    """The key that each named output is written to."""


@dataclass(frozen=True, kw_only=True)
class CompositeNode(_Node):
    """A composite and its children."""

    key: str
    children: tuple[Node, ...]
    options: Mapping[str, Plain | KeyRead] = field(default_factory=dict)
    """Besides its children, as the policy of `parallel`."""
    cases: tuple[str, ...] = ()
    """Of a switch: for each child the value that it stands for; the one after them is the `else`.
    """
    item: KeyWrite | None = None  # of a `for_each` over a list: the key of the present value

    @property
    def word(self) -> type[CompositeWord]:
        """What it is built into: of conditions alone what asks them all at every tick."""
        asks = all(is_condition(child) and not child.modifiers for child in self.children)
        return ASKING[self.key] if asks and self.key in ASKING else COMPOSITES[self.key]


@dataclass(frozen=True, kw_only=True)
class SubtreeNode(_Node):
    """The tree of another file, with values for its parameters."""

    file: str  # as the including file names it
    task: Task  # the other file, read with these arguments
    arguments: Mapping[str, Argument]
    """Values of its parameters; `KeyRead` names a key of the including file."""
    outputs: Mapping[str, KeyWrite] = field(default_factory=dict)
    """The key of the including file that takes each of its outputs."""


Node: TypeAlias = LeafNode | CompositeNode | SubtreeNode


def is_condition(node: Node) -> bool:
    """Whether a node is a condition: a leaf that is one, or what asks several of them."""
    if isinstance(node, LeafNode):
        return node.type.is_condition
    return isinstance(node, CompositeNode) and node.word.is_condition


def leaves_at(node: Node) -> Iterator[LeafNode]:
    """The node itself, if it is a leaf, after the leaves of its guards."""
    for guard in reversed(list(node.modifiers.values())):
        if isinstance(guard, LeafNode | CompositeNode):
            yield from (one for one in nodes_below(guard) if isinstance(one, LeafNode))
    if isinstance(node, LeafNode):
        yield node


def nodes_below(node: Node) -> Iterator[Node]:
    """A node and all below it in its file, in order; guards are not among them."""
    yield node
    if isinstance(node, CompositeNode):
        for child in node.children:
            yield from nodes_below(child)


def all_leaves(node: Node) -> Iterator[LeafNode]:
    """The leaves at and below a node in order, those of other files included; no guards."""
    for one in nodes_below(node):
        if isinstance(one, SubtreeNode):
            yield from all_leaves(one.task.root)
        elif isinstance(one, LeafNode):
            yield one


def hand_leaves(node: Node) -> Iterator[LeafNode]:
    """Those leaves that take something or let it go."""
    return (one for one in all_leaves(node) if one.type.hand_after and not one.type.is_condition)


class TaskFileError(UserError):
    """A task file cannot be used.

    `diagnostics` is everything that is wrong with it and its subtrees, in order.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(str(diagnostic) for diagnostic in self.diagnostics))


@dataclass(frozen=True, kw_only=True)
class Task:
    """A task file without diagnostics."""

    name: str
    description: str
    path: Path
    text: str  # the file as it was read
    scene: str  # the simulated scene that it is written for; empty if it is written for none
    parameters: Mapping[str, TaskParameter]
    poses: Mapping[str, NamedValue]  # what the file defines: tool poses, base poses and postures
    regions: Mapping[str, NamedValue]
    locations: Mapping[str, Location]
    """Where each pose and region is defined, and the scene is named (`scene:`)."""
    site: Mapping[str, Path]  # of the poses and regions that a file of places defines, that file
    outputs: Mapping[str, TaskOutput]
    root: Node
    outcomes: Outcomes  # how its tree can end
    warnings: tuple[Diagnostic, ...] = ()
    """What is probably a mistake, and does not keep the task from running."""

    @property
    def files(self) -> tuple[Path, ...]:
        """This file and those of its subtrees, each once."""
        inner = (node.task for node in nodes_below(self.root) if isinstance(node, SubtreeNode))
        paths = (self.path, *(path for task in inner for path in task.files))
        return tuple(dict.fromkeys(paths))
