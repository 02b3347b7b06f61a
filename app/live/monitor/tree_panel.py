"""The tree in the recording: two drawings, a graph, and a line of history per node."""

from __future__ import annotations

from collections.abc import Sequence

import rerun as rr
from py_trees.common import Status

from app.live.monitor.columns import Instant, Time, timelines
from app.live.monitor.glyphs import LOOK_COLOUR, LOOK_GLYPH
from app.live.monitor.tree_drawing import TreeDrawing, title
from app.live.nodes import Look, NodeInfo, looks
from app.live.snapshot import Snapshot

MARK = 0.35
"""Length of an end mark [s]."""
_ENDS = (Look.SUCCESS, Look.NOT_YET, Look.FAILURE)


class History:
    """Draws a bar for each node while it is active, and a mark where it ended."""

    def __init__(self, stream: rr.RecordingStream, titles: Sequence[str]) -> None:
        self._stream = stream
        self._looks = (Look.IDLE,) * len(titles)
        self._marked_until = [-1.0] * len(titles)
        self._states = [""] * len(titles)
        shown = (Look.RUNNING, *_ENDS)
        stream.log(
            "status",
            rr.StateConfiguration(
                values=[_state(i, look) for i in range(len(titles)) for look in shown],
                labels=[
                    name if look is Look.RUNNING else LOOK_GLYPH[look]
                    for name in titles
                    for look in shown
                ],
                colors=[LOOK_COLOUR[look] for _ in titles for look in shown],
            ),
            static=True,
        )

    def write(
        self, changed: Sequence[Snapshot], looks: Sequence[tuple[Look, ...]], *, until: Snapshot
    ) -> None:
        """Add the looks of the ticks in which one changed, and end the marks that are over."""
        rows: list[tuple[Time, list[str]]] = []
        for snapshot, now in zip(changed, looks, strict=True):
            self._end_marks(rows, snapshot)
            for index, (was, look) in enumerate(zip(self._looks, now, strict=True)):
                if look is was:
                    continue
                self._states[index] = "" if look is Look.IDLE else _state(index, look)
                self._marked_until[index] = snapshot.stamp + MARK if look in _ENDS else -1.0
            self._looks = now
            rows.append((snapshot, list(self._states)))
        self._end_marks(rows, until)
        if rows:
            states = [state for _, row in rows for state in row]
            self._stream.send_columns(
                "status",
                indexes=timelines([time for time, _ in rows]),
                columns=rr.StateChange.columns(state=states).partition(
                    [len(self._states)] * len(rows)
                ),
            )

    def _end_marks(self, rows: list[tuple[Time, list[str]]], now: Snapshot) -> None:
        over = sorted({stamp for stamp in self._marked_until if 0.0 <= stamp <= now.stamp})
        for stamp in over:
            for index, until in enumerate(self._marked_until):
                if until == stamp:
                    self._states[index], self._marked_until[index] = "", -1.0
            rows.append((Instant(tick=now.tick, stamp=stamp), list(self._states)))


def _state(index: int, look: Look) -> str:
    return f"{index}|{look.value}"


class TreePanel:
    """Draws the tree and its history."""

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream = stream
        self._tree = tuple(tree)
        self._statuses: tuple[Status, ...] | None = None
        self._drawing = TreeDrawing(stream, tree)
        self._history = History(stream, [title(node) for node in tree])

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
        if changed:
            self._drawing.write(changed)
