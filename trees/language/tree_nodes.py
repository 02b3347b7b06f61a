"""The nodes of a built tree, each under a name of its own, for viewers and summaries."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from py_trees.behaviour import Behaviour


class TreeNode(NamedTuple):
    """A node and where it is in its tree."""

    path: str
    """Names from the root down, joined by `/`; no other node of the tree has it."""
    node: Behaviour
    depth: int
    """0 for the root."""


def nodes_in_order(root: Behaviour) -> list[TreeNode]:
    """All nodes, parents before children and children in their order.

    Siblings of the same name are told apart by a number: `navigate`, `navigate 2`.
    """
    return list(_below(TreeNode(root.name, root, 0)))


def _below(parent: TreeNode) -> Iterator[TreeNode]:
    yield parent
    taken: set[str] = set()
    for child in parent.node.children:
        name, number = child.name, 1
        while name in taken:
            number += 1
            name = f"{child.name} {number}"
        taken.add(name)
        yield from _below(TreeNode(f"{parent.path}/{name}", child, parent.depth + 1))
