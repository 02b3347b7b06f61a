"""Explains in words how a run ended, from its event log and summary.

Works for every kind of end, including a killed process: the log is written during the run, and
whatever it lacks is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.core import EVENTS, End
from app.review.event_log import (
    FaultEvent,
    Log,
    LoggedEvent,
    Node,
    NodeEvent,
    NowEvent,
    PauseEvent,
    ResumeEvent,
    read_log,
)
from app.review.finished import UNFINISHED, RunRecord, read_run

_MOST_LINES = 40
"""A longer history is shortened in the middle."""


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
    damage: Sequence[str]
    """What could not be read, a line each."""

    def __str__(self) -> str:
        """The explanation as text."""
        return "\n".join(_text(self))


def explain(folder: Path) -> Explanation:
    """Explain how and why a run ended.

    Args:
        folder: of the run.

    Raises:
        DamagedRunError: its event log is missing, or no log that a run writes.
    """
    log = read_log(folder)
    end, record = log.end, read_run(folder)
    index = end.node if end else _running_leaf(log)
    outcome = end.outcome if end else UNFINISHED
    decisive = _decisive(log.events, index, outcome)
    faults = [event.faults for event in log.events if isinstance(event, FaultEvent)]
    values = decisive.values if isinstance(decisive, NodeEvent) else {}
    return Explanation(
        record=record,
        outcome=outcome,
        time=log.events[-1].time,
        node=None if index is None else log.nodes[index],
        since=decisive.time,
        reason=end.reason if end else _last_message(log.events, index),
        verdict=_last_message(log.events, 0),
        values=values or (end.values if end else {}),
        faults=faults[-1] if faults else (),
        code=_innermost(end.trace) if end else "",
        history=list(_history(log)),
        damage=list(_damage(log, record)),
    )


def _damage(log: Log, record: RunRecord) -> Iterator[str]:
    if log.left_out:
        yield f"{EVENTS}: lines that cannot be read, left out here: {log.left_out}"
    if record.damage:
        yield record.damage


def _running_leaf(log: Log) -> int | None:
    """Index of the leaf that was running when the log was cut off."""
    statuses = ["INVALID"] * len(log.nodes)
    for event in log.events:
        if isinstance(event, NodeEvent):
            statuses[event.node] = event.status
    running = [i for i, status in enumerate(statuses) if status == "RUNNING"]
    return running[-1] if running else None


def _decisive(events: Sequence[LoggedEvent], index: int | None, outcome: str) -> LoggedEvent:
    """The event in which the node that decided the end got its last status."""
    wanted = "FAILURE" if outcome == End.FAILURE.value else "RUNNING"
    for event in reversed(events):
        if isinstance(event, NodeEvent) and (event.node, event.status) == (index, wanted):
            return event
    return events[-1]


def _last_message(events: Sequence[LoggedEvent], index: int | None) -> str:
    """The last message of a node."""
    for event in reversed(events):
        if isinstance(event, NodeEvent | NowEvent) and event.node == index:
            return event.message
    return ""


def _innermost(trace: str) -> str:
    """The line of code that raised an exception."""
    frames = [line.strip() for line in trace.splitlines() if line.strip().startswith("File ")]
    return frames[-1] if frames else ""


def _history(log: Log) -> Iterator[str]:
    """What the leaves did, which were halted, and faults and pauses, with times."""
    inner = {node.path.rpartition("/")[0] for node in log.nodes}
    running: dict[int, str] = {}
    for event in sorted(log.events, key=_order):
        at = f"{event.time:8.2f} s  "
        was_at = running.pop(event.node, "") if isinstance(event, NodeEvent) else ""
        match event:
            case NodeEvent(status="RUNNING"):
                running[event.node] = event.message or "running"
            case NodeEvent(status="INVALID"):
                if was_at and log.nodes[event.node].path not in inner:
                    yield f"{at}■ {log.nodes[event.node].name}: halted"
            case NodeEvent(status="SUCCESS" | "FAILURE"):
                node, failed = log.nodes[event.node], event.status == "FAILURE"
                if node.path not in inner or (failed and node.kind in ("timeout", "retry")):
                    yield f"{at}{'✗' if failed else '✔'} {node.name}: {event.message}"
            case FaultEvent():
                yield f"{at}! {'; '.join(event.faults) or 'faults cleared'}"
            case PauseEvent():
                yield f"{at}‖ paused {event.why}"
            case ResumeEvent():
                yield f"{at}▶ resumed"


def _order(event: LoggedEvent) -> tuple[float, int]:
    """Sort key: within a tick, faults come first, and children before their parents."""
    return event.time, -event.node if isinstance(event, NodeEvent | NowEvent) else -(10**9)


def _text(run: Explanation) -> Iterator[str]:
    summary = run.record.summary
    about = {"robot": summary.robot, "scene": summary.scene, "seed": summary.seed}
    known = ", ".join(f"{key} {value}" for key, value in about.items() if value not in (None, ""))
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
    if summary.objects:
        yield ""
        yield (
            f"{summary.placed} of {summary.objects} objects placed, "
            f"{summary.attempts} grasps attempted"
        )
    if run.damage:
        yield ""
        yield from run.damage


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
        case _ if run.outcome == UNFINISHED:
            yield (
                "The end was not recorded: the run is still going on, or its process was killed. "
                f"Last event at {run.time:.2f} s, during {where}: {run.reason}"
            )
        case _:
            yield f"It ended at {run.time:.2f} s, during {where}, as {run.outcome}: {run.reason}"
    if run.node is not None:
        yield f"  in {' > '.join(run.node.path.split('/'))}"
    if run.faults:
        yield f"  the robot had a fault: {'; '.join(run.faults)}"
