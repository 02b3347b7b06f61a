"""Why a run ended as it did, in words: from the log of its events and its summary.

Works for every end that a run can have, a killed process included: the log is written as things
happen, and what it does not have is not needed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.core.events import EVENTS, Event, read_events
from app.core.outcome import End
from app.review.finished import UNFINISHED, RunRecord, read_run
from config import UserError

_MOST_LINES = 40
"""A longer story is shortened in its middle."""


class NoEventsError(UserError):
    """A run has no log of events."""


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node of the tree."""

    path: str
    name: str
    kind: str

    @property
    def title(self) -> str:
        """Its name and, if that does not tell, its kind."""
        return self.name if self.kind in ("", self.name) else f"{self.name} ({self.kind})"


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """What is to be told about a run."""

    record: RunRecord
    outcome: str
    time: float
    """Of the end, or of the last thing heard [s]."""
    node: Node | None
    """Where it ended; None if it was nowhere."""
    since: float
    """When that node ended, or else when it was entered last [s]."""
    reason: str
    verdict: str
    """What the root of the tree said last."""
    values: Mapping[str, float]
    """Numbers at that moment."""
    faults: Sequence[str]
    """Of the robot at the end."""
    code: str
    """The line of code that a leaf crashed in; empty if none did."""
    story: Sequence[str]
    """What happened, a line each."""

    def __str__(self) -> str:
        """As a text for people."""
        return "\n".join(_text(self))


def explain(folder: Path) -> Explanation:
    """Find out why a run ended as it did.

    Args:
        folder: of the run.

    Raises:
        NoEventsError: it was recorded without a log of events, or that is empty.
    """
    path = folder / EVENTS
    events = read_events(path) if path.is_file() else []
    if not events or events[0].event != "begin":
        raise NoEventsError(f"{folder}: there is no {EVENTS} to explain the run from")
    nodes = [Node(**described) for described in events[0].fields["nodes"]]
    last = events[-1]
    end = last if last.event == "end" else None
    outcome = str(end.fields["outcome"]) if end else UNFINISHED
    index = end.fields["node"] if end else _at_work(events, nodes)
    decisive = _decisive(events, index, outcome)
    faults = [event.fields["faults"] for event in events if event.event == "fault"]
    said = _said(events, index)
    return Explanation(
        record=read_run(folder),
        outcome=outcome,
        time=last.time,
        node=None if index is None else nodes[index],
        since=decisive.time,
        reason=str(end.fields["reason"]) if end else said,
        verdict=_said(events, 0),
        values=decisive.fields.get("values") or (end.fields["values"] if end else {}),
        faults=faults[-1] if faults else (),
        code=_innermost(str(end.fields["trace"])) if end else "",
        story=list(_story(events, nodes)),
    )


def _at_work(events: Sequence[Event], nodes: Sequence[Node]) -> int | None:
    """Index of the leaf that was running when the log was cut off."""
    statuses = ["INVALID"] * len(nodes)
    for event in events:
        if event.event == "node":
            statuses[event.fields["node"]] = event.fields["status"]
    running = [i for i, status in enumerate(statuses) if status == "RUNNING"]
    return running[-1] if running else None


def _decisive(events: Sequence[Event], index: int | None, outcome: str) -> Event:
    """The event that tells most about the end."""
    wanted = "FAILURE" if outcome == End.FAILURE.value else "RUNNING"
    for event in reversed(events):
        if (
            event.event == "node"
            and event.fields["node"] == index
            and event.fields["status"] == wanted
        ):
            return event
    return events[-1]


def _said(events: Sequence[Event], index: int | None) -> str:
    """What a node said last."""
    for event in reversed(events):
        if event.event in ("node", "now") and event.fields["node"] == index:
            return str(event.fields["message"])
    return ""


def _innermost(trace: str) -> str:
    """The place of an exception in the code."""
    frames = [line.strip() for line in trace.splitlines() if line.strip().startswith("File ")]
    return frames[-1] if frames else ""


def _story(events: Sequence[Event], nodes: Sequence[Node]) -> Iterator[str]:
    """What leaves did and what else happened, with times."""
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
                yield f"{at}! {faults}" if faults else f"{at}! no fault any more"
            case "pause":
                yield f"{at}‖ paused {fields['why']}"
            case "resume":
                yield f"{at}▶ resumed"


def _order(event: Event) -> tuple[float, int]:
    """Of what happened in one tick, faults come first, and leaves before what they decide."""
    return event.time, -event.fields["node"] if event.event in ("node", "now") else -(10**9)


def _text(told: Explanation) -> Iterator[str]:
    about = {key: told.record.summary.get(key) for key in ("robot", "scene", "seed")}
    known = ", ".join(f"{key} {value}" for key, value in about.items() if value is not None)
    yield f"{told.record.task}: {told.outcome} after {told.time:.2f} s" + (
        f" ({known})" if known else ""
    )
    yield ""
    yield from _why(told)
    if told.values and told.outcome != End.SUCCESS.value:
        yield ""
        yield "At that moment"
        width = max(len(name) for name in told.values)
        for name, value in told.values.items():
            yield f"  {name:{width}}  {value:g}"
    yield ""
    yield "What happened"
    story = told.story
    if len(story) > _MOST_LINES:
        half = _MOST_LINES // 2
        left_out = f"            ... {len(story) - 2 * half} more ..."
        story = [*story[:half], left_out, *story[-half:]]
    yield from (f"  {line}" for line in story or ["nothing ended"])
    if placed := told.record.summary.get("objects"):
        yield ""
        yield (
            f"{told.record.summary['placed']} of {placed} objects placed, "
            f"{told.record.summary['attempts']} grasps tried"
        )


def _why(told: Explanation) -> Iterator[str]:
    where = told.node.title if told.node else "the tree"
    match told.outcome:
        case End.SUCCESS.value:
            yield f"It succeeded: {told.reason}"
        case End.FAILURE.value:
            yield f"{where} failed at {told.since:.2f} s: {told.reason}"
            name = told.node.name if told.node else ""
            if told.verdict not in (told.reason, f"{name}: {told.reason}"):
                yield f"  so the tree failed: {told.verdict}"
        case End.CRASH.value:
            yield f"{where} crashed at {told.time:.2f} s, a mistake in its code: {told.reason}"
            if told.code:
                yield f"  {told.code}"
        case End.HARDWARE.value:
            yield f"The robot failed at {told.time:.2f} s, during {where}: {told.reason}"
        case End.INTERRUPTED.value:
            yield f"It was {told.reason} at {told.time:.2f} s, during {where}"
        case _:
            yield (
                "It left no end: its process still runs, was killed, or the machine stopped. "
                f"Last heard at {told.time:.2f} s, during {where}: {told.reason}"
            )
    if told.node is not None:
        yield f"  in {' > '.join(told.node.path.split('/'))}"
    if told.faults:
        yield f"  the robot had a fault: {'; '.join(told.faults)}"
