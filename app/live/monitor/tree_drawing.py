"""One drawing of the tree: pills with the colour and glyph of their status, and the edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import rerun as rr

from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import STATUS_COLOUR, STATUS_GLYPH, safe
from app.live.monitor.snapshot import NodeInfo, Snapshot
from app.live.monitor.tree_layout import PILL_RADIUS, Layout, shown, title

Place = Callable[[Sequence[NodeInfo]], Layout]


class TreeDrawing:
    """Draws the tree below one path, again whenever a status changes.

    Args:
        stream: where to.
        path: of the drawing's entities.
        tree: the nodes, in preorder.
        place: where they stand.
    """

    def __init__(
        self, stream: rr.RecordingStream, path: str, tree: Sequence[NodeInfo], place: Place
    ) -> None:
        self._stream = stream
        self._path = path
        self._tree = tuple(tree)
        self._place = place
        self._shown: tuple[int, ...] = ()
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
            drawn = shown(self._tree, snapshot.nodes)
            if drawn != self._shown:
                self._send_statuses(changed[begin:end])
                begin, self._shown = end, drawn
                self._send_places(snapshot)
        self._send_statuses(changed[begin:])

    def _send_places(self, snapshot: Snapshot) -> None:
        layout = self._place([self._tree[index] for index in self._shown])
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
            name=[safe(self._tree[index].name) for index in self._shown],
            kind=[self._tree[index].kind for index in self._shown],
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
        """Colours, labels and what a click on a pill tells."""
        if not changed:
            return
        nodes = [[snapshot.nodes[index] for index in self._shown] for snapshot in changed]
        per_node = [len(self._shown)] * len(changed)
        colours = np.array([[STATUS_COLOUR[n.status] for n in row] for row in nodes], np.uint8)
        names = self._titles()
        labels = [
            f"{STATUS_GLYPH[node.status]} {name}"
            for row in nodes
            for node, name in zip(row, names, strict=True)
        ]
        details = rr.AnyValues.columns(
            status=[node.status.value for row in nodes for node in row],
            message=[safe(node.message) for row in nodes for node in row],
        )
        of_edges = colours[:, 1:].reshape(-1, 3)  # every node but the root hangs on one
        for part, columns in {
            "edges": rr.LineStrips2D.columns(colors=of_edges).partition([n - 1 for n in per_node]),
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
        """Of the nodes that are drawn, with how many are hidden below them."""
        ends = [*self._shown[1:], len(self._tree)]
        hidden = [end - index - 1 for index, end in zip(self._shown, ends, strict=True)]
        return [
            title(self._tree[index]) + (f"  +{count}" if count else "")
            for index, count in zip(self._shown, hidden, strict=True)
        ]
