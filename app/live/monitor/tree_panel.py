"""The tree: two drawings, a graph, and one line of history per node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from py_trees.common import Status

from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import LOOK_COLOUR, LOOK_GLYPH
from app.live.monitor.history import History
from app.live.monitor.tree_drawing import TreeDrawing
from app.live.monitor.tree_layout import chart_layout, list_layout, title
from app.live.nodes import Look, NodeInfo, looks, parents
from app.live.snapshot import Snapshot

_IDLE_TEXT = (130, 136, 146)
"""The graph colours only the text; the grey of a pill would be hard to read."""


class TreePanel:
    """Draws the tree and its history."""

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream = stream
        self._tree = tuple(tree)
        self._titles = [title(node) for node in tree]
        self._statuses: tuple[Status, ...] | None = None
        self._drawings = (
            TreeDrawing(stream, "tree/list", tree, list_layout),
            TreeDrawing(stream, "tree/chart", tree, chart_layout),
        )
        self._history = History(stream, self._titles)
        names = [str(index) for index in range(len(tree))]
        edges = [
            (names[parent], names[child])
            for child, parent in enumerate(parents(tree))
            if parent is not None
        ]
        stream.log(
            "tree/graph",
            rr.GraphNodes(names, positions=chart_layout(tree).middles, show_labels=True),
            rr.GraphEdges(edges, graph_type="directed"),
            static=True,
        )

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the changes of a batch."""
        changed: list[Snapshot] = []
        for snapshot in batch:
            statuses = tuple(node.status for node in snapshot.nodes)
            if statuses != self._statuses:
                self._statuses = statuses
                changed.append(snapshot)
        shown = [looks(self._tree, snapshot.nodes) for snapshot in changed]
        self._history.write(changed, shown, until=batch[-1])
        if not changed:
            return
        for drawing in self._drawings:
            drawing.write(changed)
        self._send_graph(changed, [look for row in shown for look in row])

    def _send_graph(self, changed: Sequence[Snapshot], shown: Sequence[Look]) -> None:
        colour = LOOK_COLOUR | {Look.IDLE: _IDLE_TEXT}
        columns = rr.GraphNodes.columns(
            colors=np.array([colour[look] for look in shown], np.uint8),
            labels=[
                f"{LOOK_GLYPH[look]} {name}"
                for look, name in zip(shown, self._titles * len(changed), strict=True)
            ],
        )
        self._stream.send_columns(
            "tree/graph",
            indexes=timelines(changed),
            columns=columns.partition([len(self._titles)] * len(changed)),
        )
