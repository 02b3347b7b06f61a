"""The nodes of a tree as viewers see them: flat, in preorder, without the behaviours themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from py_trees.common import Status

if TYPE_CHECKING:
    from trees.language import TreeNode


@dataclass(frozen=True, kw_only=True)
class NodeInfo:
    """What does not change about a node; a tree is its nodes in preorder."""

    name: str
    kind: str
    """Its key in a task file, for example `sequence` or `navigate`."""
    depth: int
    """Number of ancestors; 0 at the root."""


class NodeStatus(NamedTuple):
    """Status of a node after a tick.

    A tuple, because every tick makes one per node: a frozen dataclass takes four times as long.
    """

    status: Status
    message: str
    """The node's feedback message; may be empty."""


def tree_view(nodes: Sequence[TreeNode]) -> list[NodeInfo]:
    """The nodes of a built tree, in preorder."""
    return [
        NodeInfo(name=n.node.name, kind=str(getattr(n.node, "key", "")), depth=n.depth)
        for n in nodes
    ]


def parents(tree: Sequence[NodeInfo]) -> tuple[int | None, ...]:
    """Index of each node's parent; None for the root."""
    found: list[int | None] = []
    path: list[int] = []
    for index, node in enumerate(tree):
        del path[node.depth :]
        found.append(path[-1] if path else None)
        path.append(index)
    return tuple(found)


def tip(nodes: Sequence[NodeStatus]) -> int:
    """Index of the node that determined the root's status: the last in preorder that shares it.

    That is the root itself before the first tick.
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
