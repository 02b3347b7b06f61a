"""Drawing of the tree in the recording: pills with the colour and glyph of their status, and edges.

In a large tree, the subtrees of nodes that are not running are hidden, unless the root's status
comes from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import rerun as rr
from py_trees.common import Status

from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import KIND_GLYPH, LOOK_COLOUR, LOOK_GLYPH, OUTLINE, printable
from app.live.nodes import Look, NodeInfo, NodeStatus, looks, parents, path_from_root, tip
from app.live.snapshot import Snapshot

Array = npt.NDArray[np.float64]

MOST_SHOWN = 40
ROW = 30.0
"""Distance of two pills in the list [scene units, about a pixel]."""
PILL_RADIUS = 12.0

_INDENT = 28.0
_CHARACTER = 7.4
_LONGEST_NAME = 34


@dataclass(frozen=True, kw_only=True, eq=False)
class Layout:
    """Pills and edges, in scene units; y points down."""

    left: Array
    """(N,) left end of every pill."""
    height: Array
    """(N,) middle of every pill."""
    width: Array
    """(N,) width of every pill."""
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


def _widths(tree: Sequence[NodeInfo]) -> Array:
    """(N,) widths of the pills: title, status and two round ends."""
    return np.array([_CHARACTER * (len(title(node)) + 3) + 2 * PILL_RADIUS for node in tree])


_PATH = "tree/list"
_OUTLINE_RADIUS = PILL_RADIUS + 3.0
_ON_TOP = (Look.IDLE, Look.SUCCESS, Look.NOT_YET, Look.FAILURE, Look.RUNNING)


class TreeDrawing:
    """Draws the tree as an indented list, again when a status changes."""

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream = stream
        self._tree = tuple(tree)
        self._visible: tuple[int, ...] = ()
        lines = rr.LineStrips2D.from_fields
        for part, look in {
            "edges": lines(radii=rr.Radius.ui_points(1.2), draw_order=1),
            "outline": lines(radii=_OUTLINE_RADIUS, colors=[OUTLINE], draw_order=1.5),
            "pills": lines(radii=PILL_RADIUS, draw_order=2),
            "labels": rr.Points2D.from_fields(
                radii=0.01, colors=(255, 255, 255), draw_order=3, show_labels=True
            ),
        }.items():
            stream.log(f"{_PATH}/{part}", look, static=True)

    def write(self, changed: Sequence[Snapshot]) -> None:
        """Draw the snapshots in which a status changed, in order; at least one."""
        begin = 0
        for end, snapshot in enumerate(changed):
            drawn = visible(self._tree, snapshot.nodes)
            if drawn != self._visible:
                self._send_statuses(changed[begin:end])
                begin, self._visible = end, drawn
                self._send_layout(snapshot)
        self._send_statuses(changed[begin:])

    def _send_layout(self, snapshot: Snapshot) -> None:
        layout = list_layout([self._tree[index] for index in self._visible])
        ends = np.stack(
            [
                *(layout.left + PILL_RADIUS, layout.height),
                *(layout.left + layout.width - PILL_RADIUS, layout.height),
            ],
            axis=1,
        ).reshape(-1, 2, 2)
        self._ends, self._edges = ends, layout.edges
        # The viewer hangs a label a little below its point.
        above = layout.middles - [0.0, PILL_RADIUS - 2.0]
        details = rr.AnyValues.columns(
            name=[printable(self._tree[index].name) for index in self._visible],
            kind=[self._tree[index].kind for index in self._visible],
        )
        for part, columns in {
            "pills": [
                *rr.LineStrips2D.columns(strips=ends).partition([len(ends)]),
                *details.partition([len(ends)]),
            ],
            "labels": rr.Points2D.columns(positions=above).partition([len(ends)]),
        }.items():
            self._stream.send_columns(
                f"{_PATH}/{part}", indexes=timelines([snapshot]), columns=columns
            )

    def _send_statuses(self, changed: Sequence[Snapshot]) -> None:
        """Colours, labels, the outline, and the details that a click on a pill shows."""
        if not changed:
            return
        nodes = [[snapshot.nodes[index] for index in self._visible] for snapshot in changed]
        per_node = [len(self._visible)] * len(changed)
        shown = [looks(self._tree, snapshot.nodes) for snapshot in changed]
        seen = [[row[index] for index in self._visible] for row in shown]
        colours = np.array([[LOOK_COLOUR[look] for look in row] for row in seen], np.uint8)
        names = self._titles()
        labels = [
            f"{LOOK_GLYPH[look]} {name}"
            for row in seen
            for look, name in zip(row, names, strict=True)
        ]
        running = [self._ends_of_running(snapshot) for snapshot in changed]
        # Every node but the root has an edge; `sorted` keeps the order of equals.
        over = [
            sorted(range(len(row) - 1), key=lambda i: _ON_TOP.index(row[i + 1])) for row in seen
        ]
        details = rr.AnyValues.columns(
            status=[node.status.value for row in nodes for node in row],
            message=[printable(node.message) for row in nodes for node in row],
        )
        for part, columns in {
            "edges": rr.LineStrips2D.columns(
                strips=[self._edges[i] for order in over for i in order],
                colors=np.array(
                    [row[i + 1] for row, order in zip(colours, over, strict=True) for i in order],
                    np.uint8,
                ).reshape(-1, 3),
            ).partition([n - 1 for n in per_node]),
            "outline": rr.LineStrips2D.columns(
                strips=[strip for row in running for strip in row]
            ).partition([len(row) for row in running]),
            "pills": [
                *rr.LineStrips2D.columns(colors=colours.reshape(-1, 3)).partition(per_node),
                *details.partition(per_node),
            ],
            "labels": rr.Points2D.columns(labels=labels).partition(per_node),
        }.items():
            self._stream.send_columns(
                f"{_PATH}/{part}", indexes=timelines(changed), columns=columns
            )

    def _ends_of_running(self, snapshot: Snapshot) -> list[Array]:
        """Ends of the pill of the active node; none when the run is over."""
        at = tip(snapshot.nodes)
        is_running = snapshot.nodes[at].status is Status.RUNNING and at in self._visible
        return [self._ends[self._visible.index(at)]] if is_running else []

    def _titles(self) -> list[str]:
        """Titles of the drawn nodes, each with the number of hidden nodes below it."""
        ends = [*self._visible[1:], len(self._tree)]
        hidden = [end - index - 1 for index, end in zip(self._visible, ends, strict=True)]
        return [
            title(self._tree[index]) + (f"  +{count}" if count else "")
            for index, count in zip(self._visible, hidden, strict=True)
        ]
