"""The tree: coloured pills, one line of history a node, what is under way, and the log."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import rerun as rr
from py_trees.common import Status

from app.monitor.columns import timelines
from app.monitor.glyphs import KIND_GLYPH, STATUS_COLOUR, STATUS_GLYPH, safe
from app.monitor.snapshot import NodeInfo, NodeStatus, Snapshot, branch, parents, tip

ROW = 30.0
"""From one pill to the one below [scene units, about a pixel]."""

_INDENT = 28.0
_PILL_RADIUS = 12.0
_CHARACTER = 7.4
_LONGEST_NAME = 30
_MESSAGE_PERIOD = 0.2
"""A changed message of the same node is kept no oftener than this [s]."""


def pill_boxes(tree: Sequence[NodeInfo]) -> npt.NDArray[np.float64]:
    """(N, 3) left end, centre height and width of each node's pill [scene units]."""
    rows = [
        (_INDENT * node.depth, ROW * index, _CHARACTER * (len(_title(node)) + 3) + 2 * _PILL_RADIUS)
        for index, node in enumerate(tree)
    ]
    return np.array(rows)


def _title(node: NodeInfo) -> str:
    name = safe(node.name)
    if len(name) > _LONGEST_NAME:
        name = name[: _LONGEST_NAME - 1] + "…"
    return f"{KIND_GLYPH.get(node.kind, '')} {name}".strip()


def _state(index: int, status: Status) -> str:
    return "" if status == Status.INVALID else f"{index}|{status.value}"


def _escape(text: str) -> str:
    return "".join(f"\\{c}" if c in r"\`*_{}[]<>()#+-.!|~" else c for c in text)


class TreePanel:
    """Draws the tree and its history.

    Args:
        stream: where to.
        tree: the nodes, in preorder.
    """

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream = stream
        self._tree = tuple(tree)
        self._is_leaf = [
            index + 1 == len(tree) or tree[index + 1].depth <= node.depth
            for index, node in enumerate(tree)
        ]
        self._statuses: tuple[Status, ...] | None = None
        self._told: tuple[int, Status, str] | None = None
        self._told_at = -float("inf")
        self._locked = False
        self._faults: frozenset[str] = frozenset()
        self._draw_still_parts()

    def _draw_still_parts(self) -> None:
        left, height, width = pill_boxes(self._tree).T
        ends = np.stack([left + _PILL_RADIUS, height, left + width - _PILL_RADIUS, height], axis=1)
        edges: list[npt.NDArray[np.float64]] = []
        self._edge_ends: list[int] = []
        for child, parent in enumerate(parents(self._tree)):
            if parent is not None:
                trunk = left[parent] + _PILL_RADIUS
                corner = (trunk, height[child])
                edges.append(np.array([(trunk, height[parent]), corner, ends[child, :2]]))
                self._edge_ends.append(child)
        log = self._stream.log
        log(
            "tree/edges",
            rr.LineStrips2D(edges, radii=rr.Radius.ui_points(1.2), draw_order=1),
            static=True,
        )
        log(
            "tree/pills",
            rr.LineStrips2D(ends.reshape(-1, 2, 2), radii=_PILL_RADIUS, draw_order=2),
            static=True,
        )
        # The viewer hangs a label a little below its point.
        middles = np.stack([left + width / 2, height - _PILL_RADIUS + 2.0], axis=1)
        log(
            "tree/labels",
            rr.Points2D(middles, radii=0.01, colors=(255, 255, 255), draw_order=3),
            rr.Points2D.from_fields(show_labels=True),
            static=True,
        )
        shown = (Status.RUNNING, Status.SUCCESS, Status.FAILURE)
        log(
            "status",
            rr.StateConfiguration(
                values=[_state(i, status) for i in range(len(self._tree)) for status in shown],
                labels=[_title(node) for node in self._tree for _ in shown],
                colors=[STATUS_COLOUR[status] for _ in self._tree for status in shown],
            ),
            static=True,
        )

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add what a batch changed."""
        changed: list[Snapshot] = []
        told: list[tuple[Snapshot, str]] = []
        events: list[tuple[Snapshot, str, str]] = []
        for snapshot in batch:
            statuses = tuple(node.status for node in snapshot.nodes)
            events += [(snapshot, *event) for event in self._events(snapshot, statuses)]
            if statuses != self._statuses:
                self._statuses = statuses
                changed.append(snapshot)
            text = self._news(snapshot)
            if text is not None:
                told.append((snapshot, text))
        if changed:
            self._send_statuses(changed)
        if told:
            self._stream.send_columns(
                "now",
                indexes=timelines([snapshot for snapshot, _ in told]),
                columns=rr.TextDocument.columns(
                    text=[text for _, text in told], media_type=["text/markdown"] * len(told)
                ),
            )
        if events:
            self._stream.send_columns(
                "log",
                indexes=timelines([snapshot for snapshot, _, _ in events]),
                columns=rr.TextLog.columns(
                    level=[level for _, level, _ in events],
                    text=[f"{snapshot.stamp:7.2f} s  {text}" for snapshot, _, text in events],
                ),
            )

    def _send_statuses(self, changed: Sequence[Snapshot]) -> None:
        times = timelines(changed)
        table = [[node.status for node in snapshot.nodes] for snapshot in changed]
        n, rows, send = len(self._tree), len(changed), self._stream.send_columns
        colours = np.array([[STATUS_COLOUR[status] for status in row] for row in table], np.uint8)
        labels = [
            f"{STATUS_GLYPH[status]} {_title(node)}"
            for row in table
            for status, node in zip(row, self._tree, strict=True)
        ]
        send(
            "tree/pills",
            indexes=times,
            columns=rr.LineStrips2D.columns(colors=colours.reshape(-1, 3)).partition([n] * rows),
        )
        send(
            "tree/edges",
            indexes=times,
            columns=rr.LineStrips2D.columns(
                colors=colours[:, self._edge_ends].reshape(-1, 3)
            ).partition([len(self._edge_ends)] * rows),
        )
        send(
            "tree/labels",
            indexes=times,
            columns=rr.Points2D.columns(labels=labels).partition([n] * rows),
        )
        states = [_state(i, status) for row in table for i, status in enumerate(row)]
        send(
            "status",
            indexes=times,
            columns=rr.StateChange.columns(state=states).partition([n] * rows),
        )

    def _news(self, snapshot: Snapshot) -> str | None:
        """What is under way, if that is news."""
        index = tip(snapshot.nodes)
        node = snapshot.nodes[index]
        news = (index, node.status, node.message)
        same_node = self._told is not None and news[:2] == self._told[:2]
        if news == self._told or (same_node and snapshot.stamp < self._told_at + _MESSAGE_PERIOD):
            return None
        self._told, self._told_at = news, snapshot.stamp
        names = [_escape(safe(self._tree[i].name)) for i in branch(self._tree, index)]
        return (
            f"### {STATUS_GLYPH[node.status]} {names[-1]}\n\n"
            f"{_escape(safe(node.message))}\n\n*{' / '.join(names[:-1])}*"
        )

    def _events(self, snapshot: Snapshot, statuses: tuple[Status, ...]) -> list[tuple[str, str]]:
        """Level and text of what is worth a line in the log."""
        before = self._statuses or (Status.INVALID,) * len(statuses)
        events = [
            _line(self._tree[index], snapshot.nodes[index])
            for index, (was, status) in enumerate(zip(before, statuses, strict=True))
            if status != was
            and status != Status.INVALID
            and (self._is_leaf[index] or status != Status.RUNNING)
        ]
        if snapshot.locked and not self._locked:
            events.append(("INFO", "grasp locked"))
        self._locked = snapshot.locked
        faults = frozenset(fault.text for fault in snapshot.state.faults)
        events += [("ERROR", f"fault: {safe(text)}") for text in sorted(faults - self._faults)]
        self._faults = faults
        return events


def _line(node: NodeInfo, now: NodeStatus) -> tuple[str, str]:
    level = "WARN" if now.status == Status.FAILURE else "INFO"
    reason = f": {safe(now.message)}" if now.message else ""
    return level, f"{STATUS_GLYPH[now.status]} {safe(node.name)}{reason}"
