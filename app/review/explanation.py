"""Explains in words how a run ended, from its event log and summary.

Works for every kind of end, including a killed process: the log is written during the run, and
whatever it lacks is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.core import EVENTS, End, Event, read_events
from app.review.finished import UNFINISHED, RunRecord, read_run
from config import UserError

_MOST_LINES = 40
"""A longer history is shortened in the middle."""


class NoEventsError(UserError):
    """A run has no event log."""


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node of the tree."""

    path: str
    name: str
    kind: str

    @property
    def title(self) -> str:
        """Its name, and its kind if that differs."""
        return self.name if self.kind in ("", self.name) else f"{self.name} ({self.kind})"


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """How and why a run ended."""

    record: RunRecord
    outcome: str
    time: float
    """Of the end, or of the last event [s]."""
    node: Node | None
    """The node in which it ended; None if there is none."""
    since: float
    """When that node failed, or else was last entered [s]."""
    reason: str
    verdict: str
    """The last message of the root of the tree."""
    values: Mapping[str, float]
    """Key figures at that moment."""
    faults: Sequence[str]
    """Of the robot at the end."""
    code: str
    """The line of code in which a leaf crashed; empty if none did."""
    history: Sequence[str]
    """What happened, one event per line."""

    def __str__(self) -> str:
        """The explanation as text."""
        return "\n".join(_text(self))


def explain(folder: Path) -> Explanation:
    """Explain how and why a run ended.

    Args:
        folder: of the run.

    Raises:
        NoEventsError: its event log is missing or empty.
    """
    path = folder / EVENTS
    events = read_events(path) if path.is_file() else []
    if not events or events[0].event != "begin":
        raise NoEventsError(f"{folder}: no {EVENTS} with the events of a run")
    nodes = [Node(**described) for described in events[0].fields["nodes"]]
    last = events[-1]
    end = last if last.event == "end" else None
    outcome = str(end.fields["outcome"]) if end else UNFINISHED
    index = end.fields["node"] if end else _running_leaf(events, nodes)
    decisive = _decisive(events, index, outcome)
    faults = [event.fields["faults"] for event in events if event.event == "fault"]
    return Explanation(
        record=read_run(folder),
        outcome=outcome,
        time=last.time,
        node=None if index is None else nodes[index],
        since=decisive.time,
        reason=str(end.fields["reason"]) if end else _last_message(events, index),
        verdict=_last_message(events, 0),
        values=decisive.fields.get("values") or (end.fields["values"] if end else {}),
        faults=faults[-1] if faults else (),
        code=_innermost(str(end.fields["trace"])) if end else "",
        history=list(_history(events, nodes)),
    )


def _running_leaf(events: Sequence[Event], nodes: Sequence[Node]) -> int | None:
    """Index of the leaf that was running when the log was cut off."""
    statuses = ["INVALID"] * len(nodes)
    for event in events:
        if event.event == "node":
            statuses[event.fields["node"]] = event.fields["status"]
    running = [i for i, status in enumerate(statuses) if status == "RUNNING"]
    return running[-1] if running else None


def _decisive(events: Sequence[Event], index: int | None, outcome: str) -> Event:
    """The event in which the node that decided the end got its last status."""
    wanted = "FAILURE" if outcome == End.FAILURE.value else "RUNNING"
    for event in reversed(events):
        if (
            event.event == "node"
            and event.fields["node"] == index
            and event.fields["status"] == wanted
        ):
            return event
    return events[-1]


def _last_message(events: Sequence[Event], index: int | None) -> str:
    """The last message of a node."""
    for event in reversed(events):
        if event.event in ("node", "now") and event.fields["node"] == index:
            return str(event.fields["message"])
    return ""


def _innermost(trace: str) -> str:
    """The line of code that raised an exception."""
    frames = [line.strip() for line in trace.splitlines() if line.strip().startswith("File ")]
    return frames[-1] if frames else ""


def _history(events: Sequence[Event], nodes: Sequence[Node]) -> Iterator[str]:
    """What the leaves did, and faults and pauses, with times."""
    inner = {node.path.rpartition("/")[0] for node in nodes}
    for event in sorted(events, key=_order):
        fields, at = event.fields, f"{event.time:8.2f} s  "
        match event.event:
            case "node":
                node = nodes[fields["node"]]
                if node.path not in inner and fields["status"] in ("SUCCESS", "FAILURE"):
                    mark = "✔" if fields["status"] == "SUCCESS" else "✗"
                    yield f"{at}{mark} {node.name}: {fields['message']}"
                elif node.kind in ("timeout", "retry") and fields["status"] == "FAILURE":
                    yield f"{at}✗ {node.name}: {fields['message']}"
            case "fault":
                faults = "; ".join(fields["faults"])
                yield f"{at}! {faults}" if faults else f"{at}! faults cleared"
            case "pause":
                yield f"{at}‖ paused {fields['why']}"
            case "resume":
                yield f"{at}▶ resumed"


def _order(event: Event) -> tuple[float, int]:
    """Sort key: within a tick, faults come first, and children before their parents."""
    return event.time, -event.fields["node"] if event.event in ("node", "now") else -(10**9)


def _text(run: Explanation) -> Iterator[str]:
    about = {key: run.record.summary.get(key) for key in ("robot", "scene", "seed")}
    known = ", ".join(f"{key} {value}" for key, value in about.items() if value is not None)
    yield f"{run.record.task}: {run.outcome} after {run.time:.2f} s" + (
        f" ({known})" if known else ""
    )
    yield ""
    yield from _why(run)
    if run.values and run.outcome != End.SUCCESS.value:
        yield ""
        yield "At that moment"
        width = max(len(name) for name in run.values)
        for name, value in run.values.items():
            yield f"  {name:{width}}  {value:g}"
    yield ""
    yield "What happened"
    history = run.history
    if len(history) > _MOST_LINES:
        half = _MOST_LINES // 2
        omitted = f"            ... {len(history) - 2 * half} more ..."
        history = [*history[:half], omitted, *history[-half:]]
    yield from (f"  {line}" for line in history or ["no node ended"])
    if placed := run.record.summary.get("objects"):
        yield ""
        yield (
            f"{run.record.summary['placed']} of {placed} objects placed, "
            f"{run.record.summary['attempts']} grasps attempted"
        )


def _why(run: Explanation) -> Iterator[str]:
    where = run.node.title if run.node else "the tree"
    match run.outcome:
        case End.SUCCESS.value:
            yield f"It succeeded: {run.reason}"
        case End.FAILURE.value:
            yield f"{where} failed at {run.since:.2f} s: {run.reason}"
            name = run.node.name if run.node else ""
            if run.verdict not in (run.reason, f"{name}: {run.reason}"):
                yield f"  so the tree failed: {run.verdict}"
        case End.CRASH.value:
            yield f"{where} crashed at {run.time:.2f} s, an error in its code: {run.reason}"
            if run.code:
                yield f"  {run.code}"
        case End.HARDWARE.value:
            yield f"The robot failed at {run.time:.2f} s, during {where}: {run.reason}"
        case End.INTERRUPTED.value:
            yield f"It was {run.reason} at {run.time:.2f} s, during {where}"
        case _:
            yield (
                "The end was not recorded: the run is still going on, or its process was killed. "
                f"Last event at {run.time:.2f} s, during {where}: {run.reason}"
            )
    if run.node is not None:
        yield f"  in {' > '.join(run.node.path.split('/'))}"
    if run.faults:
        yield f"  the robot had a fault: {'; '.join(run.faults)}"
