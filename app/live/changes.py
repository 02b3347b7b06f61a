"""What the ticks of a run changed, as the lines of a log: for people who watch, and recorded."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from py_trees.common import Status

from app.live.nodes import (
    LOOK_GLYPH,
    STATUS_GLYPH,
    Look,
    NodeInfo,
    NodeStatus,
    leaves,
    path_from_root,
    shortened,
)
from app.live.run_snapshot import Snapshot

LONGEST_NAME = 40
_MOST = 2000  # changes that wait to be taken; more are forgotten, the oldest first


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """Constant data of a run."""

    task: str
    where: str
    description: str = ""  # what the task does, for people
    objects: int = 0  # number of objects to be placed; 0 if unknown or none
    real: bool = False  # whether it is armed, to move a real robot


class LogLine(NamedTuple):
    """Something that happened."""

    time: float  # of the task [s]
    severity: str  # info, warning or error
    node: int | None  # index; None if it concerns the robot, or the whole run
    text: str
    stamp: float = 0.0  # of the session, as in the recording [s]


class Noted(NamedTuple):
    """What may have changed at a time."""

    time: float  # of the task [s]
    stamp: float  # of the session [s]
    nodes: tuple[NodeStatus, ...]
    faults: tuple[str, ...]
    paused: str = ""
    placed: int = 0
    too_slow: str = ""


class Changes:
    """A line for every change of a leaf, of the robot's faults, and of pauses; and times of nodes.

    The loop notes its ticks; another thread takes what they changed. `objects` is the number of
    objects to be placed, 0 if unknown.
    """

    def __init__(self, tree: Sequence[NodeInfo], objects: int = 0) -> None:
        self._objects = objects
        self._leaves, above = leaves(tree), [path_from_root(tree, i) for i in range(len(tree))]
        asked = {index + 1 for index, node in enumerate(tree) if node.kind == "until"}
        self._questions = {index for index, path in enumerate(above) if asked.intersection(path)}
        self._names = [shortened(node.title, LONGEST_NAME) for node in tree]
        never = NodeStatus(Status.INVALID, "")
        self._last = Noted(0.0, 0.0, (never,) * len(tree), ())
        self.noted: deque[Noted] = deque(maxlen=_MOST)
        """What waits to be taken."""
        self._seen = ("", 0, False)  # pause, number of faults, slowness of the last tick
        self._spent, self._since = [0.0] * len(tree), [0.0] * len(tree)

    def note(self, tick: Snapshot) -> None:
        """Keep a tick if something changed in it."""
        faults = tick.state.faults
        seen = (tick.paused, len(faults), bool(tick.too_slow))
        if tick.changed or seen != self._seen:
            self._seen = seen
            self.noted.append(_noted(tick))

    def of(self, tick: Snapshot) -> list[LogLine]:
        """What a tick changed."""
        self.noted.append(_noted(tick))
        return list(self.take())

    def take(self) -> Iterator[LogLine]:
        """What the ticks changed that were noted since the last call."""
        while self.noted:
            before, self._last = self._last, self.noted.popleft()
            for line in self._lines(before, self._last):
                yield line._replace(stamp=self._last.stamp)

    def spent(self, time: float) -> list[float]:
        """How long each node has run until a task time [s]."""
        nodes = zip(self._last.nodes, self._spent, self._since, strict=True)
        return [
            spent + max(0.0, time - since) if now.status is Status.RUNNING else spent
            for now, spent, since in nodes
        ]

    def _lines(self, before: Noted, now: Noted) -> Iterator[LogLine]:
        if now.faults != before.faults:
            text = f"! FAULT: {'; '.join(now.faults)}" if now.faults else "! faults cleared"
            yield LogLine(now.time, "error" if now.faults else "info", None, text)
        if now.paused != before.paused:
            text = f"‖ PAUSED {now.paused}" if now.paused else "▶ resumed"
            yield LogLine(now.time, "warning" if now.paused else "info", None, text)
        if now.too_slow and not before.too_slow:
            yield LogLine(now.time, "warning", None, f"! {now.too_slow}")
        changed = [
            index
            for index, (old, new) in enumerate(zip(before.nodes, now.nodes, strict=True))
            if new is not old and new.status is not old.status
        ]
        for index in changed:
            if before.nodes[index].status is Status.RUNNING:
                self._spent[index] += now.time - self._since[index]
            self._since[index] = now.time
        for index in sorted({*changed} & self._leaves):
            yield from self._change(now.time, index, before.nodes[index].status, now.nodes[index])
        if now.placed != before.placed and self._objects:
            text = f"  {now.placed} of {self._objects} placed"
            yield LogLine(now.time, "info", None, text)

    def _change(
        self, time: float, index: int, before: Status, now: NodeStatus
    ) -> Iterator[LogLine]:
        name = self._names[index]
        if now.status is Status.INVALID:
            if before is Status.RUNNING:
                yield LogLine(time, "info", index, f"■ {name}: halted")
            return
        message = " ".join(now.message.split())
        failed = now.status is Status.FAILURE
        answered_no = failed and before is not Status.RUNNING
        glyph = LOOK_GLYPH[Look.NOT_YET] if answered_no else STATUS_GLYPH[now.status]
        is_setback = failed and not answered_no and index not in self._questions
        severity = "warning" if is_setback else "info"
        text = f"{glyph} {name}" + (f": {message}" if message not in name else "")
        yield LogLine(time, severity, index, text)


def _noted(tick: Snapshot) -> Noted:
    texts = tuple(fault.text for fault in tick.state.faults)
    now = (tick.nodes, texts, tick.paused, tick.placed, tick.too_slow)
    return Noted(tick.time, tick.stamp, *now)
