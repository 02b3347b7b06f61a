"""Positions of the nodes in the drawings of a tree: an indented list, and a top-down chart.

Both draw pills of one height whose width follows their text. In a large tree, nodes that are not
running are collapsed: their subtrees are hidden, unless the root's status comes from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from py_trees.common import Status

from app.live.monitor.glyphs import KIND_GLYPH, printable
from app.live.nodes import NodeInfo, NodeStatus, parents, path_from_root, tip

Array = npt.NDArray[np.float64]

MOST_SHOWN = 40
"""Number of nodes above which nodes that are not running are collapsed."""
ROW = 30.0
"""From one pill of the list to the one below [scene units, about a pixel]."""
PILL_RADIUS = 12.0

_INDENT = 28.0
_LEVEL = 64.0
_GAP = 14.0
_CHARACTER = 7.4
_LONGEST_NAME = 34


@dataclass(frozen=True, kw_only=True, eq=False)
class Layout:
    """Pills and the lines between them, in scene units; y points down."""

    left: Array
    """(N,) left end of every pill."""
    height: Array
    """(N,) its middle."""
    width: Array
    """(N,) its width."""
    edges: tuple[Array, ...]
    """(3 or 4, 2) lines from a parent to its child, in order of the children."""

    @property
    def middles(self) -> Array:
        """(N, 2) middles of the pills."""
        return np.stack([self.left + self.width / 2, self.height], axis=1)


def title(node: NodeInfo) -> str:
    """Title of a node in a drawing."""
    name = printable(node.title)
    if len(name) > _LONGEST_NAME:
        name = name[: _LONGEST_NAME - 1] + "…"
    return f"{KIND_GLYPH.get(node.kind, '')} {name}".strip()


def visible(tree: Sequence[NodeInfo], nodes: Sequence[NodeStatus]) -> tuple[int, ...]:
    """Indices of the nodes that are drawn, in preorder."""
    if len(tree) <= MOST_SHOWN:
        return tuple(range(len(tree)))
    decisive = path_from_root(tree, tip(nodes))
    drawn: list[int] = []
    collapsed = len(tree)  # depth of the node whose subtree is being skipped
    for index, node in enumerate(tree):
        if node.depth > collapsed:
            continue
        drawn.append(index)
        expanded = nodes[index].status == Status.RUNNING or index in decisive
        collapsed = len(tree) if expanded else node.depth
    return tuple(drawn)


def list_layout(tree: Sequence[NodeInfo]) -> Layout:
    """One pill per row, children below and to the right of their parent."""
    left = np.array([_INDENT * node.depth for node in tree])
    height = np.array([ROW * row for row in range(len(tree))])
    trunk = left + PILL_RADIUS
    edges = [
        np.array([(trunk[p], height[p]), (trunk[p], height[c]), (trunk[c], height[c])])
        for c, p in enumerate(parents(tree))
        if p is not None
    ]
    return Layout(left=left, height=height, width=_widths(tree), edges=tuple(edges))


def chart_layout(tree: Sequence[NodeInfo]) -> Layout:
    """Children side by side, centred below their parent, as close as their subtrees allow.

    The tidy tree of Reingold and Tilford (1981), with pills of different widths.
    """
    above, widths = parents(tree), _widths(tree)
    children: list[list[int]] = [[] for _ in tree]
    for child, parent in enumerate(above):
        if parent is not None:
            children[parent].append(child)
    offset = np.zeros(len(tree))  # of a node's middle from its parent's
    outlines: dict[int, list[tuple[float, float]]] = {}  # left and right end, level by level
    for node in reversed(range(len(tree))):
        merged: list[tuple[float, float]] = []
        for child in children[node]:
            outline = outlines.pop(child)
            ends = zip(merged, outline, strict=False)
            offset[child] = max((_GAP + right - left for (_, right), (left, _) in ends), default=0)
            moved = [(left + offset[child], right + offset[child]) for left, right in outline]
            beside = zip(merged, moved, strict=False)
            merged = [
                *((left, right) for (left, _), (_, right) in beside),
                *merged[len(moved) :],
                *moved[len(merged) :],
            ]
        middle = sum(offset[children[node][i]] for i in (0, -1)) / 2 if children[node] else 0.0
        offset[children[node]] -= middle
        outlines[node] = [
            (-widths[node] / 2, widths[node] / 2),
            *((left - middle, right - middle) for left, right in merged),
        ]
    middles = np.zeros(len(tree))
    for node, parent in enumerate(above):
        middles[node] = offset[node] + (0.0 if parent is None else middles[parent])
    left = middles - widths / 2
    middles, left = middles - left.min(), left - left.min()
    height = np.array([_LEVEL * node.depth for node in tree])
    edges = []
    for child, parent in enumerate(above):
        if parent is not None:
            bend = height[parent] + _LEVEL / 2
            edges.append(
                np.array(
                    [
                        (middles[parent], height[parent]),
                        (middles[parent], bend),
                        (middles[child], bend),
                        (middles[child], height[child]),
                    ]
                )
            )
    return Layout(left=left, height=height, width=widths, edges=tuple(edges))


def _widths(tree: Sequence[NodeInfo]) -> Array:
    """(N,) widths of the pills: title, status and two round ends."""
    return np.array([_CHARACTER * (len(title(node)) + 3) + 2 * PILL_RADIUS for node in tree])
