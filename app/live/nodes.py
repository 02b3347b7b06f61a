"""Nodes of a tree for viewers: flat, in preorder, without the behaviours."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from py_trees.common import Status

from trees.language import TreeNode

_LONGEST_GIVEN = 24
_NEXT = "next_goal"
_UNITS = ("m", "s", "percent")


@dataclass(frozen=True, kw_only=True)
class NodeInfo:
    """Constant data of a node; a tree is a list of them in preorder."""

    name: str
    kind: str  # its key in a task file, for example `sequence` or `navigate`
    depth: int  # number of ancestors; 0 at the root
    given: str = ""  # its main argument, as `at_table` of a `navigate`; empty for most
    does: str = ""  # what a leaf does, in a sentence

    @property
    def title(self) -> str:
        """Name and argument."""
        return f"{self.name} → {self.given}" if self.given else self.name


class NodeStatus(NamedTuple):
    """Status of a node after a tick; a tuple, which is quicker to make than a dataclass."""

    status: Status
    message: str  # feedback message; may be empty


class Look(StrEnum):
    """State of a node as it is drawn."""

    IDLE = "idle"
    RUNNING = "running"
    SUCCESS = "success"
    NOT_YET = "not yet"  # a failure after which the tree continues: a condition or an attempt
    FAILURE = "failure"


_LOOKS = {
    Status.INVALID: Look.IDLE,
    Status.RUNNING: Look.RUNNING,
    Status.SUCCESS: Look.SUCCESS,
    Status.FAILURE: Look.NOT_YET,
}
LOOK_GLYPH = {
    Look.IDLE: "·",
    Look.RUNNING: "▶",
    Look.SUCCESS: "✔",
    Look.NOT_YET: "○",
    Look.FAILURE: "✗",
}
STATUS_GLYPH = {Status.INVALID: "·", Status.RUNNING: "▶", Status.SUCCESS: "✔", Status.FAILURE: "✗"}


def tree_view(nodes: Sequence[TreeNode]) -> list[NodeInfo]:
    """The nodes of a built tree, in preorder."""
    return [
        NodeInfo(
            name=n.node.name,
            kind=str(getattr(n.node, "key", "")),
            depth=n.depth,
            given=_in_words(getattr(n.node, "given", {})),
            does="" if n.node.children else (type(n.node).__doc__ or "").partition("\n")[0],
        )
        for n in nodes
    ]


def _in_words(given: Mapping[str, object]) -> str:
    """The names of poses, regions and keys among a leaf's arguments, or else its first value."""
    given = {word: value for word, value in given.items() if word != _NEXT}
    names = [str(name) for value in given.values() if (name := getattr(value, "name", None))]
    others = [
        f"{value:g} {_unit(word)}".strip() if isinstance(value, float) else str(value)
        for word, value in given.items()
    ]
    return shortened(", ".join(names) or next(iter(others), ""), _LONGEST_GIVEN)


def _unit(word: str) -> str:
    unit = word.rpartition("_")[2]
    return unit if unit in _UNITS else ""


def shortened(text: str, longest: int) -> str:
    """The text on one line, with at most so many characters."""
    text = " ".join(text.split())
    return text if len(text) <= longest else text[: longest - 1] + "…"


def looks(tree: Sequence[NodeInfo], nodes: Sequence[NodeStatus]) -> tuple[Look, ...]:
    """How every node is drawn: FAILURE only for what has failed the whole tree."""
    found = [_LOOKS[node.status] for node in nodes]
    if nodes[0].status is Status.FAILURE:
        for index, parent in enumerate(parents(tree)):
            if found[index] is Look.NOT_YET and (parent is None or found[parent] is Look.FAILURE):
                found[index] = Look.FAILURE
    return tuple(found)


def parents(tree: Sequence[NodeInfo]) -> tuple[int | None, ...]:
    """Index of each node's parent; None for the root."""
    found: list[int | None] = []
    path: list[int] = []
    for index, node in enumerate(tree):
        del path[node.depth :]
        found.append(path[-1] if path else None)
        path.append(index)
    return tuple(found)


def leaves(tree: Sequence[NodeInfo]) -> set[int]:
    """Indices of the nodes without children."""
    return {*range(len(tree))} - {*parents(tree)}


def tip(nodes: Sequence[NodeStatus]) -> int:
    """Index of the node that determined the root's status: the last in preorder that shares it.

    The root before the first tick.
    """
    root = nodes[0].status
    if root == Status.INVALID:
        return 0
    return max(index for index, node in enumerate(nodes) if node.status == root)


def path_from_root(tree: Sequence[NodeInfo], index: int) -> tuple[int, ...]:
    """Indices from the root down to a node, both included."""
    above = parents(tree)
    path = [index]
    while (parent := above[path[-1]]) is not None:
        path.append(parent)
    return tuple(reversed(path))
