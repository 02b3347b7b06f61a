"""Explains how a run ended and what went wrong first, from its event log and summary.

It works for every kind of end, including a killed process; missing data is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.core import EVENTS, End
from app.review.attempts import (
    Attempt,
    LeafTime,
    attempts,
    attempts_text,
    leaf_times_text,
    longest_leaves,
)
from app.review.cause import Cause, cause_of, fault_cause, first_setback, topic_of
from app.review.event_log import (
    FaultEvent,
    Log,
    LoggedEvent,
    Node,
    NodeEvent,
    NowEvent,
    read_log,
)
from app.review.finished import UNFINISHED, RunRecord, read_run
from app.review.timeline import Timeline, history, timeline
from app.task_time import task_time

_MOST_LINES = 40


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """How and why a run ended; times are those of the task [s]."""

    record: RunRecord
    outcome: str
    time: float
    """Of the end, or of the last event."""
    node: Node | None
    """The node in which it ended; None if there is none."""
    since: float
    """When that node failed, or else was last entered."""
    reason: str
    verdict: str
    values: Mapping[str, float]
    faults: Sequence[str]
    code: str
    """The line of code in which a leaf crashed; empty if none did."""
    cause: Cause | None
    """The earliest cause; None if nothing went wrong."""
    where: Node | None
    attempts: Sequence[Attempt]
    leaf_times: Sequence[LeafTime]
    paused_s: float
    history: Sequence[str]
    damage: Sequence[str]

    def __str__(self) -> str:
        return "\n".join(_text(self))


def explain(folder: Path) -> Explanation:
    """Explain how and why a run ended.

    Raises:
        DamagedRunError: its event log is missing or invalid.
    """
    session = read_log(folder)
    log = session.for_people()
    end, record, spans = log.end, read_run(folder), timeline(log)
    duration = record.summary.duration_s
    index = end.node if end else _running_leaf(log)
    outcome = end.outcome if end else UNFINISHED
    decisive = _decisive(log.events, index, outcome)
    faults = [event.faults for event in log.events if isinstance(event, FaultEvent)]
    values = decisive.values if isinstance(decisive, NodeEvent) else {}
    cause = _cause(spans, index, outcome, end.reason if end else "")
    return Explanation(
        record=record,
        outcome=outcome,
        time=log.events[-1].time if duration is None else duration,
        node=None if index is None else log.nodes[index],
        since=decisive.time,
        reason=end.reason if end else _last_message(log.events, index),
        verdict=_last_message(log.events, 0),
        values=values or (end.values if end else {}),
        faults=faults[-1] if faults else (),
        code=_innermost(end.trace) if end else "",
        cause=cause,
        where=None if cause is None or cause.node is None else log.nodes[cause.node],
        attempts=attempts(spans),
        leaf_times=longest_leaves(spans),
        paused_s=session.paused_s,
        history=list(history(log, spans, session.pauses)),
        damage=list(_damage(log, record)),
    )


def _cause(run: Timeline, index: int | None, outcome: str, reason: str) -> Cause | None:
    """The earliest cause of the end."""
    match outcome:
        case End.SUCCESS.value | End.CRASH.value:
            return None
        case End.HARDWARE.value:
            return fault_cause(run) or Cause(
                time=run.end, node=index, reason=reason, topic=topic_of(reason), is_fault=True
            )
        case End.FAILURE.value:
            for node in (0, index):  # a log with missing lines may not have the root's failure
                rounds = run.rounds.get(node, ()) if node is not None else ()
                if rounds and rounds[-1].status == "FAILURE":
                    return cause_of(run, rounds[-1])
            return None
        case _:
            return first_setback(run) or fault_cause(run)


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
    for event in reversed(events):
        if isinstance(event, NodeEvent | NowEvent) and event.node == index:
            return event.message
    return ""


def _innermost(trace: str) -> str:
    frames = [line.strip() for line in trace.splitlines() if line.strip().startswith("File ")]
    return frames[-1] if frames else ""


def _text(run: Explanation) -> Iterator[str]:
    summary = run.record.summary
    about = {"robot": summary.robot, "scene": summary.scene, "seed": summary.seed}
    known = ", ".join(f"{key} {value}" for key, value in about.items() if value not in (None, ""))
    time = task_time(run.time, run.paused_s)
    yield f"{run.record.task}: {run.outcome} after {time}" + (f" ({known})" if known else "")
    yield ""
    yield from _why(run)
    if run.values and run.outcome != End.SUCCESS.value:
        yield ""
        yield "At that moment"
        width = max(len(name) for name in run.values)
        for name, value in run.values.items():
            yield f"  {name:{width}}  {value:g}"
    if len(run.attempts) > 1 or any(one.cause for one in run.attempts):
        yield ""
        yield "Attempts"
        yield from attempts_text(run.attempts)
    if run.leaf_times:
        yield ""
        yield "What took the time"
        yield from leaf_times_text(run.leaf_times, run.time)
    yield ""
    yield "What happened"
    lines = run.history
    if len(lines) > _MOST_LINES:
        half = _MOST_LINES // 2
        omitted = f"            ... {len(lines) - 2 * half} more ..."
        lines = [*lines[:half], omitted, *lines[-half:]]
    yield from (f"  {line}" for line in lines or ["no node ended"])
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
    title = run.node.title if run.node else "the tree"
    match run.outcome:
        case End.SUCCESS.value:
            yield f"It succeeded: {run.reason}"
        case End.FAILURE.value:
            yield from _failure(run, title)
        case End.CRASH.value:
            yield f"{title} crashed at {run.time:.2f} s, an error in its code: {run.reason}"
            if run.code:
                yield f"  {run.code}"
        case End.HARDWARE.value:
            yield f"The robot failed at {run.time:.2f} s, during {title}: {run.reason}"
        case End.INTERRUPTED.value:
            yield f"It was {run.reason} at {run.time:.2f} s, during {title}"
        case _ if run.outcome == UNFINISHED:
            yield (
                "The end was not recorded: the run is still going on, or its process was killed "
                f"or is frozen; its log is {run.record.silent}. "
                f"Last event at {run.time:.2f} s, during {title}: {run.reason}"
            )
        case _:
            yield f"It ended at {run.time:.2f} s, during {title}, as {run.outcome}: {run.reason}"
    reported = run.outcome == End.FAILURE.value or (run.cause and run.cause.reason == run.reason)
    if run.cause is not None and not reported:
        yield f"  what went wrong first: {cause_text(run)}"
    decided = run.where if run.outcome == End.FAILURE.value and run.where else run.node
    if decided is not None:
        yield f"  in {' > '.join(decided.path.split('/'))}"
    if run.faults:
        yield f"  the robot had a fault: {'; '.join(run.faults)}"


def _failure(run: Explanation, title: str) -> Iterator[str]:
    """The cause; then what failed last and what the root said, where they say more."""
    last = f"{title} failed at {run.since:.2f} s: {run.reason}"
    if run.cause is None:
        yield last
    else:
        yield cause_text(run)
        if run.where != run.node or run.cause.reason != run.reason:
            yield f"  it ended when {last}"
    name = run.node.name if run.node else ""
    if run.verdict not in (run.reason, f"{name}: {run.reason}"):
        yield f"  so the tree failed: {run.verdict}"


def cause_text(run: Explanation) -> str:
    """The cause in one line; empty without one."""
    if (cause := run.cause) is None:
        return ""
    where = run.where.title if run.where else "nothing"
    words = f"{cause.topic[:1].upper()}{cause.topic[1:]}: " if cause.topic else ""
    if cause.is_fault:
        return f"{words}the robot had a fault at {cause.time:.2f} s, during {where}: {cause.reason}"
    return f"{words}{where} failed at {cause.time:.2f} s: {cause.reason}"
