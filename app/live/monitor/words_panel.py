"""What is told in words: what is under way and why, the blackboard, and the log of transitions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import rerun as rr
from py_trees.common import Status

from app.live.monitor.columns import timelines
from app.live.monitor.every import Every
from app.live.monitor.glyphs import STATUS_GLYPH, safe
from app.live.monitor.snapshot import NodeInfo, NodeStatus, Snapshot, branch, tip

_MESSAGE_PERIOD = 0.2
"""A changed message of the same node, or a changed blackboard, is kept no oftener than this [s]."""
_LONGEST_VALUE = 80
_NOTHING = "*nothing is written on it*"


class WordsPanel:
    """Writes the texts.

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
        self._statuses = (Status.INVALID,) * len(tree)
        self._told: tuple[int, Status, str] | None = None
        self._told_at = -float("inf")
        self._board = ""
        self._board_turn = Every(_MESSAGE_PERIOD)
        self._locked = False
        self._faults: frozenset[str] = frozenset()

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add what a batch has to tell."""
        told: list[tuple[Snapshot, str]] = []
        boards: list[tuple[Snapshot, str]] = []
        events: list[tuple[Snapshot, str, str]] = []
        for snapshot in batch:
            events += [(snapshot, *event) for event in self._events(snapshot)]
            text = self._news(snapshot)
            if text is not None:
                told.append((snapshot, text))
            if self._board_turn.due(snapshot.stamp):
                board = _table(snapshot.blackboard)
                if board != self._board:
                    self._board = board
                    boards.append((snapshot, board))
        self._send_documents("now", told)
        self._send_documents("blackboard", boards)
        if events:
            self._stream.send_columns(
                "log",
                indexes=timelines([snapshot for snapshot, _, _ in events]),
                columns=rr.TextLog.columns(
                    level=[level for _, level, _ in events],
                    text=[f"{snapshot.stamp:7.2f} s  {text}" for snapshot, _, text in events],
                ),
            )

    def _send_documents(self, path: str, told: Sequence[tuple[Snapshot, str]]) -> None:
        if told:
            self._stream.send_columns(
                path,
                indexes=timelines([snapshot for snapshot, _ in told]),
                columns=rr.TextDocument.columns(
                    text=[text for _, text in told], media_type=["text/markdown"] * len(told)
                ),
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
        names = [_escape(self._tree[i].name) for i in branch(self._tree, index)]
        return (
            f"### {STATUS_GLYPH[node.status]} {names[-1]}\n\n"
            f"{_escape(node.message)}\n\n*{' / '.join(names[:-1])}*"
        )

    def _events(self, snapshot: Snapshot) -> list[tuple[str, str]]:
        """Level and text of what is worth a line in the log."""
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
        events += [("ERROR", f"fault: {safe(text)}") for text in sorted(faults - self._faults)]
        self._faults = faults
        return events


def _line(node: NodeInfo, now: NodeStatus) -> tuple[str, str]:
    level = "WARN" if now.status == Status.FAILURE else "INFO"
    reason = f": {safe(now.message)}" if now.message else ""
    return level, f"{STATUS_GLYPH[now.status]} {safe(node.name)}{reason}"


def _table(blackboard: Mapping[str, object]) -> str:
    """A line for every key."""
    if not blackboard:
        return _NOTHING
    rows = (f"| {_escape(key)} | {_value(value)} |" for key, value in sorted(blackboard.items()))
    return "\n".join(["| key | value |", "|---|---|", *rows])


def _value(value: object) -> str:
    text = str(value)
    return _escape(text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 1] + "…")


def _escape(text: str) -> str:
    """The text as Markdown shows it, in characters that the viewer can draw."""
    return "".join(f"\\{c}" if c in r"\`*_{}[]<>()#+-.!|~" else c for c in safe(text))
