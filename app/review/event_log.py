"""Event log of a run, validated line by line.

A log that was cut off by a kill or a full disk can be read: incomplete lines are counted and left
out. Everything else that no run writes is refused, with its line.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os.path import isfile
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from app.core import EVENTS
from config import UserError

Index = Annotated[int, Field(ge=0)]
Values = Mapping[str, Annotated[float, Field(allow_inf_nan=False)]]


class DamagedRunError(UserError):
    """A run cannot be read; the text says which file and line, and why."""


class _Checked(BaseModel):
    """A model without conversions that ignores unknown fields."""

    model_config = ConfigDict(strict=True, extra="ignore", frozen=True)


class Node(_Checked):
    """A node of the tree."""

    path: str
    name: str
    kind: str
    given: str = ""  # its main argument, as `NodeInfo.given`
    does: str = ""

    @property
    def title(self) -> str:
        """Name, and kind if that differs."""
        return self.name if self.kind in ("", self.name) else f"{self.name} ({self.kind})"


class LoggedEvent(_Checked):
    """One line of the log."""

    time: Annotated[float, Field(ge=0.0, le=1e9, allow_inf_nan=False)]  # on the session's clock [s]


class Begin(LoggedEvent):
    """Before the first tick."""

    nodes: Annotated[list[Node], Field(min_length=1)]


class NodeEvent(LoggedEvent):
    """A node changed its status."""

    node: Index
    status: Literal["INVALID", "RUNNING", "SUCCESS", "FAILURE"]
    message: str
    values: Values = {}


class NowEvent(LoggedEvent):
    """The active node, once a second."""

    node: Index
    message: str


class FaultEvent(LoggedEvent):
    """The robot's faults changed."""

    faults: list[str]


class PauseEvent(LoggedEvent):
    """A person paused the run."""

    why: str


class ResumeEvent(LoggedEvent):
    """The run goes on."""


class EndEvent(LoggedEvent):
    """After the last tick."""

    outcome: Literal["success", "failure", "crash", "hardware fault", "interrupted"]
    reason: str
    node: Index | None
    trace: str
    values: Values = {}


_KINDS: Mapping[str, type[LoggedEvent]] = {
    "begin": Begin,
    "node": NodeEvent,
    "now": NowEvent,
    "fault": FaultEvent,
    "pause": PauseEvent,
    "resume": ResumeEvent,
    "end": EndEvent,
}


@dataclass(frozen=True, kw_only=True)
class Log:
    """Events of one run."""

    nodes: Sequence[Node]
    events: Sequence[LoggedEvent]
    """In the order of the file; the first is a `Begin`, and an `EndEvent` is the last."""
    left_out: int

    @property
    def end(self) -> EndEvent | None:
        """The event of the end; None if it is not recorded."""
        last = self.events[-1]
        return last if isinstance(last, EndEvent) else None

    @cached_property
    def pauses(self) -> Sequence[tuple[float, float]]:
        """When the task's clock was held, on the session's clock [s]."""
        found: list[tuple[float, float]] = []
        since: float | None = None
        for event in self.events:
            if isinstance(event, PauseEvent) and since is None:
                since = event.time
            elif isinstance(event, ResumeEvent) and since is not None:
                found.append((since, event.time))
                since = None
        return found if since is None else [*found, (since, self.events[-1].time)]

    @property
    def began(self) -> float:
        """Time of the first tick, on the session's clock [s]."""
        return self.events[1].time if len(self.events) > 1 and not self.left_out else 0.0

    @property
    def paused_s(self) -> float:
        """Total duration of the pauses [s]."""
        return sum(end - begin for begin, end in self.pauses)

    def task_time(self, time: float) -> float:
        """Time of the task, from its first tick without pauses, for a session time [s]."""
        paused = sum(min(end, time) - begin for begin, end in self.pauses if begin < time)
        return max(0.0, time - self.began - paused)

    def session_time(self, time: float) -> float:
        """Session time of a task time [s]; a pause counts where it begins."""
        time += self.began
        for begin, end in self.pauses:
            time += end - begin if begin < time else 0.0
        return time

    def for_people(self) -> Log:
        """The same log with times of the task."""
        events = [
            event.model_copy(update={"time": round(self.task_time(event.time), 4)})
            for event in self.events
        ]
        return replace(self, events=events)


def read_log(folder: Path) -> Log:
    """The event log of a run; raises DamagedRunError if it is missing, or invalid."""
    path = folder / EVENTS
    try:
        if not isfile(path):
            raise OSError(None, "there is no such file")
        lines = enumerate(path.read_bytes().split(b"\n"), start=1)
    except OSError as error:
        raise DamagedRunError(
            f"{path}: the events of the run cannot be read ({error.strerror}); name another run"
        ) from error
    read = [(number, found) for number, line in lines if (found := _fields(line)) is not None]
    if not read or read[0][1]["event"] != "begin":
        raise DamagedRunError(f"{path}: does not begin as the log of a run; name another run")
    events: list[LoggedEvent] = []
    for number, fields in read:
        if fields["event"] in ("", *_KINDS):  # others are of a later version
            events.append(_checked(fields, events, f"{path}:{number}"))
    assert isinstance(events[0], Begin)
    return Log(nodes=events[0].nodes, events=events, left_out=read[-1][0] - len(read))


def _fields(line: bytes) -> dict[str, Any] | None:
    """What a line says; None if it is not JSON, as after a kill."""
    try:
        read = json.loads(line.decode("utf-8"))
    except (ValueError, RecursionError):
        return None
    fields = read if isinstance(read, dict) else {}
    return {"time": None} | fields | {"event": str(fields.get("event", ""))}


def recorded_time(folder: Path, time: float) -> float:
    """The session time of a task time of a run [s]."""
    try:
        return read_log(folder).session_time(time)
    except DamagedRunError:
        return time


def _checked(fields: Mapping[str, Any], before: Sequence[LoggedEvent], where: str) -> LoggedEvent:
    """An event as its model; raises DamagedRunError if no run writes it after those before."""
    problem = ""
    try:
        model = _KINDS[fields["event"]]
        checked = model.model_validate(fields)
    except KeyError:
        problem = "is no event"
    except ValidationError as invalid:
        problem = first_problem(invalid)
    else:
        if before and model is Begin:
            problem = "the run begins again"
        elif before and isinstance(before[-1], EndEvent):
            problem = "the run goes on after its end"
        elif before and isinstance(before[0], Begin):
            node, count = getattr(checked, "node", None), len(before[0].nodes)
            if node is not None and node >= count:
                problem = f"node {node} is none of the {count} of the tree"
    if problem:
        hint = "no run writes this: the file was changed; look at the recording instead"
        raise DamagedRunError(f"{where}: {problem}; {hint}")
    return checked


def first_problem(invalid: ValidationError) -> str:
    """The first problem in one line: where, and what was expected."""
    first = invalid.errors(include_url=False)[0]
    where = ".".join(str(key) for key in first["loc"])
    message = first["msg"].removeprefix("Value error, ")
    message = message[:1].lower() + message[1:]
    return f"{where[:100]}: {message}" if where else message
