"""One drawing of the tree: pills with the colour and glyph of their status, and the edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import rerun as rr

from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import STATUS_COLOUR, STATUS_GLYPH, printable
from app.live.monitor.tree_layout import PILL_RADIUS, Layout, title, visible
from app.live.nodes import NodeInfo
from app.live.snapshot import Snapshot


class TreeDrawing:
    """Draws the tree below one path, again whenever a status changes.

    Args:
        stream: where to.
        path: of the drawing's entities.
        tree: the nodes, in preorder.
        layout: positions of the nodes that are drawn.
    """

    def __init__(
        self,
        stream: rr.RecordingStream,
        path: str,
        tree: Sequence[NodeInfo],
        layout: Callable[[Sequence[NodeInfo]], Layout],
    ) -> None:
        self._stream = stream
        self._path = path
        self._tree = tuple(tree)
        self._layout = layout
        self._visible: tuple[int, ...] = ()
        lines = rr.LineStrips2D.from_fields
        for part, look in {
            "edges": lines(radii=rr.Radius.ui_points(1.2), draw_order=1),
            "pills": lines(radii=PILL_RADIUS, draw_order=2),
            "labels": rr.Points2D.from_fields(
                radii=0.01, colors=(255, 255, 255), draw_order=3, show_labels=True
            ),
        }.items():
            stream.log(f"{path}/{part}", look, static=True)

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
        layout = self._layout([self._tree[index] for index in self._visible])
        ends = np.stack(
            [
                *(layout.left + PILL_RADIUS, layout.height),
                *(layout.left + layout.width - PILL_RADIUS, layout.height),
            ],
            axis=1,
        )
        # The viewer hangs a label a little below its point.
        above = layout.middles - [0.0, PILL_RADIUS - 2.0]
        details = rr.AnyValues.columns(
            name=[printable(self._tree[index].name) for index in self._visible],
            kind=[self._tree[index].kind for index in self._visible],
        )
        for part, columns in {
            "edges": rr.LineStrips2D.columns(strips=layout.edges).partition([len(layout.edges)]),
            "pills": [
                *rr.LineStrips2D.columns(strips=ends.reshape(-1, 2, 2)).partition([len(ends)]),
                *details.partition([len(ends)]),
            ],
            "labels": rr.Points2D.columns(positions=above).partition([len(ends)]),
        }.items():
            self._stream.send_columns(
                f"{self._path}/{part}", indexes=timelines([snapshot]), columns=columns
            )

    def _send_statuses(self, changed: Sequence[Snapshot]) -> None:
        """Colours, labels, and the details that a click on a pill shows."""
        if not changed:
            return
        nodes = [[snapshot.nodes[index] for index in self._visible] for snapshot in changed]
        per_node = [len(self._visible)] * len(changed)
        colours = np.array([[STATUS_COLOUR[n.status] for n in row] for row in nodes], np.uint8)
        names = self._titles()
        labels = [
            f"{STATUS_GLYPH[node.status]} {name}"
            for row in nodes
            for node, name in zip(row, names, strict=True)
        ]
        details = rr.AnyValues.columns(
            status=[node.status.value for row in nodes for node in row],
            message=[printable(node.message) for row in nodes for node in row],
        )
        edge_colours = colours[:, 1:].reshape(-1, 3)  # every node but the root has one
        for part, columns in {
            "edges": rr.LineStrips2D.columns(colors=edge_colours).partition(
                [n - 1 for n in per_node]
            ),
            "pills": [
                *rr.LineStrips2D.columns(colors=colours.reshape(-1, 3)).partition(per_node),
                *details.partition(per_node),
            ],
            "labels": rr.Points2D.columns(labels=labels).partition(per_node),
        }.items():
            self._stream.send_columns(
                f"{self._path}/{part}", indexes=timelines(changed), columns=columns
            )

    def _titles(self) -> list[str]:
        """Titles of the drawn nodes, each with the number of nodes hidden below it."""
        ends = [*self._visible[1:], len(self._tree)]
        hidden = [end - index - 1 for index, end in zip(self._visible, ends, strict=True)]
        return [
            title(self._tree[index]) + (f"  +{count}" if count else "")
            for index, count in zip(self._visible, hidden, strict=True)
        ]
