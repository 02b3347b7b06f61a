"""The tree: two drawings, a graph, and one line of history per node."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from py_trees.common import Status

from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import STATUS_COLOUR, STATUS_GLYPH
from app.live.monitor.tree_drawing import TreeDrawing
from app.live.monitor.tree_layout import chart_layout, list_layout, title
from app.live.nodes import NodeInfo, parents
from app.live.snapshot import Snapshot

_SHOWN = (Status.RUNNING, Status.SUCCESS, Status.FAILURE)
_IDLE_TEXT = (130, 136, 146)
"""The graph colours only the text; the grey of a pill would be hard to read."""


class TreePanel:
    """Draws the tree and its history.

    Args:
        stream: where to.
        tree: the nodes, in preorder.
    """

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream = stream
        self._titles = [title(node) for node in tree]
        self._statuses: tuple[Status, ...] | None = None
        self._drawings = (
            TreeDrawing(stream, "tree/list", tree, list_layout),
            TreeDrawing(stream, "tree/chart", tree, chart_layout),
        )
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
        stream.log(
            "status",
            rr.StateConfiguration(
                values=[_state(i, status) for i in range(len(tree)) for status in _SHOWN],
                labels=[name for name in self._titles for _ in _SHOWN],
                colors=[STATUS_COLOUR[status] for _ in tree for status in _SHOWN],
            ),
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
        if not changed:
            return
        for drawing in self._drawings:
            drawing.write(changed)
        self._send_graph(changed)
        states = [_state(i, n.status) for s in changed for i, n in enumerate(s.nodes)]
        self._stream.send_columns(
            "status",
            indexes=timelines(changed),
            columns=rr.StateChange.columns(state=states).partition(
                [len(self._titles)] * len(changed)
            ),
        )

    def _send_graph(self, changed: Sequence[Snapshot]) -> None:
        statuses = [node.status for snapshot in changed for node in snapshot.nodes]
        look = STATUS_COLOUR | {Status.INVALID: _IDLE_TEXT}
        columns = rr.GraphNodes.columns(
            colors=np.array([look[status] for status in statuses], np.uint8),
            labels=[
                f"{STATUS_GLYPH[status]} {name}"
                for status, name in zip(statuses, self._titles * len(changed), strict=True)
            ],
        )
        self._stream.send_columns(
            "tree/graph",
            indexes=timelines(changed),
            columns=columns.partition([len(self._titles)] * len(changed)),
        )


def _state(index: int, status: Status) -> str:
    return "" if status == Status.INVALID else f"{index}|{status.value}"
