"""The tree in the recording: pills with their status, and a line of history per node."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr
from py_trees.common import Status

from app.live.monitor.columns import Instant, Time, timelines
from app.live.monitor.glyphs import KIND_GLYPH, LOOK_COLOUR, printable
from app.live.nodes import LOOK_GLYPH, Look, NodeInfo, looks, parents, shortened, tip
from app.live.run_snapshot import Snapshot
from config.arrays import Array

ROW = 30.0  # distance of two pills [scene units, about a pixel]
PILL_RADIUS = 12.0
MARK = 0.35  # length of an end mark in the history [s]

_INDENT = 28.0
_CHARACTER = 7.4
_LONGEST_NAME = 34
_ENDS = (Look.SUCCESS, Look.NOT_YET, Look.FAILURE)
_LIST = "tree/list"


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
            states = rr.StateChange.columns(state=[state for _, row in rows for state in row])
            self._stream.send_columns(
                "status",
                indexes=timelines([time for time, _ in rows]),
                columns=states.partition([len(self._states)] * len(rows)),
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
    """Draws the tree as an indented list of pills with their looks, and its history."""

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream, self._tree = stream, tuple(tree)
        self._statuses: tuple[Status, ...] | None = None
        self._titles = [title(node) for node in tree]
        self._history = History(stream, self._titles)
        self._ends = ends = pills(tree)
        middles = ends.mean(axis=1)
        lines = rr.LineStrips2D.from_fields
        looks: dict[str, Any] = {
            "edges": lines(strips=edges(tree, ends), radii=rr.Radius.ui_points(1.2), draw_order=1),
            "outline": lines(radii=PILL_RADIUS + 3.0, colors=[(255, 255, 255)], draw_order=1.5),
            "pills": lines(strips=list(ends), radii=PILL_RADIUS, draw_order=2),
            "labels": rr.Points2D.from_fields(
                # The viewer hangs a label a little below its point.
                positions=middles - [0.0, PILL_RADIUS - 2.0],
                radii=0.01,
                colors=(255, 255, 255),
                draw_order=3,
                show_labels=True,
            ),
        }
        for part, body in looks.items():
            stream.log(f"{_LIST}/{part}", body, static=True)

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
            self._draw(changed, shown)

    def _draw(self, changed: Sequence[Snapshot], looks: Sequence[tuple[Look, ...]]) -> None:
        """Send colours, labels and the outline."""
        count = len(self._titles)
        colours = np.array([[LOOK_COLOUR[look] for look in row] for row in looks], np.uint8)
        labels = [
            f"{LOOK_GLYPH[look]} {name}"
            for row in looks
            for look, name in zip(row, self._titles, strict=True)
        ]
        tips = [(tip(snapshot.nodes), snapshot) for snapshot in changed]
        running = [seen.nodes[at].status is Status.RUNNING for at, seen in tips]
        outlined = [self._ends[at] for (at, _), runs in zip(tips, running, strict=True) if runs]
        per_node, per_edge = [count] * len(changed), [count - 1] * len(changed)
        lines = rr.LineStrips2D.columns
        for part, columns, lengths in (
            # Every node but the root has an edge.
            ("edges", lines(colors=colours[:, 1:].reshape(-1, 3)), per_edge),
            ("pills", lines(colors=colours.reshape(-1, 3)), per_node),
            ("labels", rr.Points2D.columns(labels=labels), per_node),
            ("outline", lines(strips=outlined), [int(runs) for runs in running]),
        ):
            self._stream.send_columns(
                f"{_LIST}/{part}", indexes=timelines(changed), columns=columns.partition(lengths)
            )


def title(node: NodeInfo) -> str:
    """Title of a node in a drawing."""
    name = shortened(printable(node.title), _LONGEST_NAME)
    return f"{KIND_GLYPH.get(node.kind, '')} {name}".strip()


def pills(tree: Sequence[NodeInfo]) -> Array:
    """(N, 2, 2) centres of the round ends of the pills, a row each; y points down."""
    left = np.array([_INDENT * node.depth + PILL_RADIUS for node in tree])
    width = np.array([_CHARACTER * (len(title(node)) + 3) for node in tree])
    height = ROW * np.arange(len(tree))
    ends: Array = np.stack([left, height, left + width, height], axis=1).reshape(-1, 2, 2)
    return ends


def edges(tree: Sequence[NodeInfo], ends: Array) -> list[Array]:
    """(3, 2) lines from the parent of every node but the root down and to the node."""
    found = []
    for child, parent in enumerate(parents(tree)):
        if parent is not None:
            (x, y), (_, below) = ends[parent, 0], ends[child, 0]
            found.append(np.array([(x, y), (x, below), ends[child, 0]]))
    return found
