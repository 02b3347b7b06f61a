"""What a task file says, checked and with every name and parameter resolved."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from trees.language.kinds import Plain
from trees.language.mistakes import Place
from trees.language.registry import LeafType
from trees.language.values import Given, KeyRead, KeyWrite

if TYPE_CHECKING:
    from trees.language.task import Task

Modifiers: TypeAlias = "Mapping[str, Plain | KeyRead | LeafNode]"
"""Values by key, in the order in which they wrap, innermost first; that of a guard is a condition.

A `KeyRead` stands only in a task that was loaded with open parameters.
"""


@dataclass(frozen=True, kw_only=True)
class LeafNode:
    """A leaf and its arguments."""

    place: Place
    name: str
    modifiers: Modifiers
    type: LeafType
    arguments: Mapping[str, Given]
    """What the file gives; the leaf's own defaults are not filled in. Of `set`, keys and values."""
    outputs: Mapping[str, KeyWrite] = field(default_factory=dict)
    """The key that each named output is written to."""


@dataclass(frozen=True, kw_only=True)
class CompositeNode:
    """A composite and its children."""

    place: Place
    name: str
    modifiers: Modifiers
    key: str
    children: tuple[Node, ...]
    options: Mapping[str, Plain | KeyRead] = field(default_factory=dict)
    """What the file says besides, as the policy of `parallel`."""


@dataclass(frozen=True, kw_only=True)
class SubtreeNode:
    """The tree of another file, with values for its parameters."""

    place: Place
    name: str
    modifiers: Modifiers
    file: str
    """As the including file names it."""
    task: Task
    """The other file, read with these arguments."""
    arguments: Mapping[str, Given]
    """Values of its parameters; `KeyRead` names a key of the including file."""
    outputs: Mapping[str, KeyWrite] = field(default_factory=dict)
    """The key of the including file that takes each of its outputs."""


Node: TypeAlias = LeafNode | CompositeNode | SubtreeNode


def nodes_below(node: Node) -> Iterator[Node]:
    """A node and all below it in its file, in order; guards are not among them."""
    yield node
    if isinstance(node, CompositeNode):
        for child in node.children:
            yield from nodes_below(child)
