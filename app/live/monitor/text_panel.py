"""Texts of the recording: active node and message, blackboard, and log of transitions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import rerun as rr
from py_trees.common import Status

from app.live.feed import Throttle
from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import STATUS_GLYPH, printable
from app.live.nodes import NodeInfo, NodeStatus, path_from_root, tip
from app.live.snapshot import Snapshot

_MESSAGE_PERIOD = 0.2
"""Shortest time between two messages of a node, or two blackboards [s]."""
_LONGEST_VALUE = 80
_EMPTY = "*empty*"


class TextPanel:
    """Writes the texts."""

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream = stream
        self._tree = tuple(tree)
        self._is_leaf = [
            index + 1 == len(tree) or tree[index + 1].depth <= node.depth
            for index, node in enumerate(tree)
        ]
        self._statuses = (Status.INVALID,) * len(tree)
        self._active: tuple[int, Status, str] | None = None
        self._active_since = -float("inf")
        self._board = ""
        self._board_throttle = Throttle(_MESSAGE_PERIOD)
        self._locked = False
        self._faults: frozenset[str] = frozenset()

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the texts of a batch."""
        messages: list[tuple[Snapshot, str]] = []
        boards: list[tuple[Snapshot, str]] = []
        events: list[tuple[Snapshot, str, str]] = []
        for snapshot in batch:
            events += [(snapshot, *event) for event in self._events(snapshot)]
            text = self._changed_message(snapshot)
            if text is not None:
                messages.append((snapshot, text))
            if self._board_throttle.due(snapshot.stamp):
                board = _table(snapshot.blackboard)
                if board != self._board:
                    self._board = board
                    boards.append((snapshot, board))
        self._send_documents("now", messages)
        self._send_documents("blackboard", boards)
        if events:
            self._stream.send_columns(
                "log",
                indexes=timelines([snapshot for snapshot, _, _ in events]),
                columns=rr.TextLog.columns(
                    level=[level for _, level, _ in events],
                    text=[f"{snapshot.time:7.2f} s  {text}" for snapshot, _, text in events],
                ),
            )

    def _send_documents(self, path: str, texts: Sequence[tuple[Snapshot, str]]) -> None:
        if texts:
            self._stream.send_columns(
                path,
                indexes=timelines([snapshot for snapshot, _ in texts]),
                columns=rr.TextDocument.columns(
                    text=[text for _, text in texts], media_type=["text/markdown"] * len(texts)
                ),
            )

    def _changed_message(self, snapshot: Snapshot) -> str | None:
        """The active node with its message, if that has changed."""
        index = tip(snapshot.nodes)
        node = snapshot.nodes[index]
        active = (index, node.status, node.message)
        same_node = self._active is not None and active[:2] == self._active[:2]
        too_soon = snapshot.stamp < self._active_since + _MESSAGE_PERIOD
        if active == self._active or (same_node and too_soon):
            return None
        self._active, self._active_since = active, snapshot.stamp
        names = [_escape(self._tree[i].name) for i in path_from_root(self._tree, index)]
        return (
            f"### {STATUS_GLYPH[node.status]} {names[-1]}\n\n"
            f"{_escape(node.message)}\n\n*{' / '.join(names[:-1])}*"
        )

    def _events(self, snapshot: Snapshot) -> list[tuple[str, str]]:
        statuses = tuple(node.status for node in snapshot.nodes)
        events = []
        if statuses != self._statuses:
            events = [
                _line(self._tree[index], snapshot.nodes[index])
                for index, (was, status) in enumerate(zip(self._statuses, statuses, strict=True))
                if status != was
                and status != Status.INVALID
                and (self._is_leaf[index] or status != Status.RUNNING)
            ]
            self._statuses = statuses
        if snapshot.locked and not self._locked:
            events.append(("INFO", "grasp locked"))
        self._locked = snapshot.locked
        faults = frozenset(fault.text for fault in snapshot.state.faults)
        events += [("ERROR", f"fault: {printable(text)}") for text in sorted(faults - self._faults)]
        self._faults = faults
        return events


def _line(node: NodeInfo, now: NodeStatus) -> tuple[str, str]:
    level = "WARN" if now.status == Status.FAILURE else "INFO"
    reason = f": {printable(now.message)}" if now.message else ""
    return level, f"{STATUS_GLYPH[now.status]} {printable(node.name)}{reason}"


def _table(blackboard: Mapping[str, object]) -> str:
    if not blackboard:
        return _EMPTY
    rows = (f"| {_escape(key)} | {_value(value)} |" for key, value in sorted(blackboard.items()))
    return "\n".join(["| key | value |", "|---|---|", *rows])


def _value(value: object) -> str:
    text = str(value)
    return _escape(text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 1] + "…")


def _escape(text: str) -> str:
    """The text escaped for Markdown, in characters that the viewer can draw."""
    return "".join(f"\\{c}" if c in r"\`*_{}[]<>()#+-.!|~" else c for c in printable(text))
