"""Explains how a run ended and what went wrong first, from its event log and summary.

It works for every kind of end, including a killed process; missing data is left out.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from py_trees.common import Status

from app.core import EVENTS, TOO_SLOW, End
from app.live import STATUS_GLYPH
from app.review.cause import Cause, cause_of, fault_cause, first_setback, topic_of
from app.review.event_log import FaultEvent, LoggedEvent, Node, NodeEvent, NowEvent, read_log
from app.review.finished import UNFINISHED, RunRecord, read_run
from app.review.timeline import Span, Timeline, retold, timeline
from app.task_time import task_time
from config import counted

_MOST_LINES, _MOST_ATTEMPTS, _MOST_LEAVES = 40, 12, 5


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """One round of something that is tried again."""

    what: str
    begin: float
    end: float
    result: str
    cause: Cause | None  # the cause of its failure; None if it succeeded


@dataclass(frozen=True, kw_only=True)
class LeafTime:
    """A leaf, and its total time [s]."""

    name: str
    seconds: float
    rounds: int


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """How and why a run ended; times are those of the task [s]."""

    record: RunRecord
    outcome: str
    time: float  # of the end, or of the last event
    node: Node | None  # the node in which it ended; None if there is none
    since: float  # when that node failed, or else was last entered
    reason: str
    verdict: str  # message of the root
    values: Mapping[str, float]
    faults: Sequence[str]
    code: str  # the line of code in which a leaf crashed; empty if none did
    cause: Cause | None  # the earliest cause; None if nothing went wrong
    where: Node | None
    attempts: Sequence[Attempt]
    leaf_times: Sequence[LeafTime]
    paused_s: float
    history: Sequence[str]
    damage: Sequence[str]

    @property
    def sections(self) -> list[list[str]]:
        """The text in parts, each of some lines: what ended, why, and more with a title each."""
        return [list(lines) for lines in _sections(self) if lines]

    @property
    def headline(self) -> str:
        """The first cause, in one line."""
        return self.why[0]

    @property
    def why(self) -> list[str]:
        """The first cause, in one line, and more lines about it."""
        return list(_why(self))

    def __str__(self) -> str:
        return "\n\n".join("\n".join(lines) for lines in self.sections)


def explain(folder: Path) -> Explanation:
    """Explain how and why a run ended.

    Raises DamagedRunError: its event log is missing or invalid.
    """
    session = read_log(folder)
    log = session.for_people()
    end, record, spans = log.end, read_run(folder), timeline(log)
    duration = record.summary.duration_s
    index = end.node if end else spans.running()
    outcome = end.outcome if end else UNFINISHED
    decisive = _decisive(log.events, index, outcome)
    faults = [event.faults for event in log.events if isinstance(event, FaultEvent)]
    values = decisive.values if isinstance(decisive, NodeEvent) else {}
    cause = _cause(spans, index, outcome, end.reason if end else "")
    left_out = f"{EVENTS}: lines that cannot be read, left out here: {log.left_out}"
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
        attempts=_attempts(spans),
        leaf_times=_longest_leaves(spans),
        paused_s=session.paused_s,
        history=[
            f"{line.time:8.2f} s  {line.text}"
            for line in retold(session).lines
            if line.node is None or not line.text.startswith(STATUS_GLYPH[Status.RUNNING])
        ],
        damage=[*([left_out] if log.left_out else []), *filter(None, [record.damage])],
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


def _attempts(run: Timeline) -> list[Attempt]:
    """The rounds of everything below a `retry`, in order; of `forever` only the failed ones."""
    spans = [
        span
        for node, above in enumerate(run.nodes)
        if above.kind in ("retry", "forever")
        for child in run.children(node)
        for span in run.rounds.get(child, ())
        if above.kind == "retry" or span.status == "FAILURE"
    ]
    return [_attempt(run, span) for span in sorted(spans, key=lambda s: (s.begin, s.node))]


def _attempt(run: Timeline, span: Span) -> Attempt:
    cause = cause_of(run, span) if span.status == "FAILURE" else None
    result = {"SUCCESS": "done", "INVALID": "halted", "RUNNING": "under way"}.get(span.status, "")
    if cause is not None:
        where = "" if cause.node is None else f"{run.nodes[cause.node].name}: "
        result = f"{topic_of(cause.reason) or 'failed'}: {where}{cause.reason}"
    name = run.nodes[span.node].name
    return Attempt(what=name, begin=span.begin, end=span.end, result=result, cause=cause)


def _longest_leaves(run: Timeline) -> list[LeafTime]:
    """The leaves that took the most time, the longest first."""
    found = []
    for node, rounds in run.rounds.items():
        lasting = [span.seconds for span in rounds if span.seconds > 0.0]
        if run.is_leaf(node) and lasting:
            name = " > ".join(run.nodes[node].path.split("/")[-2:])
            found.append(LeafTime(name=name, seconds=sum(lasting), rounds=len(lasting)))
    return sorted(found, key=lambda one: -one.seconds)[:_MOST_LEAVES]


def _sections(run: Explanation) -> Iterator[Sequence[str]]:
    """The parts of the text, each of some lines."""
    summary = run.record.summary
    about = {"robot": summary.robot, "scene": summary.scene, "seed": summary.seed}
    known = ", ".join(f"{key} {value}" for key, value in about.items() if value not in (None, ""))
    time = task_time(run.time, run.paused_s)
    yield [f"{run.record.task}: {run.outcome} after {time}" + (f" ({known})" if known else "")]
    if summary.too_slow and summary.too_slow not in run.reason:
        yield [f"First of all, {summary.too_slow}"]
    yield list(_why(run))
    if run.values and run.outcome != End.SUCCESS.value:
        width = max(map(len, run.values))
        figures = [f"  {name:{width}}  {value:g}" for name, value in run.values.items()]
        yield ["At that moment", *figures]
    if len(run.attempts) > 1 or any(one.cause for one in run.attempts):
        rows = [
            f"  {number:>3}  {one.begin:>6.1f} s  {f'{one.end - one.begin:.1f} s':>7}  "
            f"{one.what}: {one.result}"
            for number, one in enumerate(run.attempts, start=1)
        ]
        head = f"  {'#':>3}  {'from':>8}  {'took':>7}  what came of it"
        yield ["Attempts", head, *_shortened(rows, _MOST_ATTEMPTS)]
    if run.leaf_times:
        rows = [
            f"  {one.seconds:>7.1f} s  {100.0 * one.seconds / max(run.time, 1e-9):>3.0f} %  "
            f"{counted(one.rounds, 'round'):>9}  {one.name}"
            for one in run.leaf_times
        ]
        yield ["What took the time", *rows]
    lines = [f"  {line}" for line in run.history or ["no node ended"]]
    yield ["What happened", *_shortened(lines, _MOST_LINES)]
    if summary.handled:
        placed = f"{summary.placed or 0} of {counted(summary.objects or 0, 'object')} placed"
        yield [f"{placed}, {counted(summary.attempts or 0, 'grasp')} attempted"]
    if summary.localisation:
        yield [f"Localisation: {summary.localisation}"]
    yield run.damage


def _shortened(lines: Sequence[str], most: int) -> list[str]:
    """At most that many lines; of more, the middle is left out."""
    if len(lines) <= most:
        return list(lines)
    half = most // 2
    return [*lines[:half], f"       ... {len(lines) - 2 * half} more ...", *lines[-half:]]


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
        case End.HARDWARE.value if TOO_SLOW in run.reason:
            yield f"The run could not go on at {run.time:.2f} s, during {title}: {run.reason}"
        case End.HARDWARE.value:
            yield f"The robot failed at {run.time:.2f} s, during {title}: {run.reason}"
        case End.INTERRUPTED.value:
            yield f"It was {run.reason} at {run.time:.2f} s, during {title}"
        case _:
            yield (
                "The end was not recorded: the run is still going on, or its process was killed "
                f"or is frozen; its log is {run.record.silent}. "
                f"Last event at {run.time:.2f} s, during {title}: {run.reason}"
            )
    reported = run.outcome == End.FAILURE.value or (run.cause and run.cause.reason == run.reason)
    if run.cause is not None and not reported:
        yield f"  what went wrong first: {_cause_text(run.cause, run.where)}"
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
        yield _cause_text(run.cause, run.where)
        for one in run.cause.answered:
            yield f"  before, at {one.time:.2f} s, and answered by a fallback: {one.reason}"
        if run.where != run.node or run.cause.reason != run.reason:
            yield f"  it ended when {last}"
    name = run.node.name if run.node else ""
    if run.verdict not in (run.reason, f"{name}: {run.reason}"):
        yield f"  so the tree failed: {run.verdict}"


def _cause_text(cause: Cause, node: Node | None) -> str:
    """The cause, at a node, in one line."""
    where = node.title if node else "nothing"
    words = f"{cause.topic[:1].upper()}{cause.topic[1:]}: " if cause.topic else ""
    if cause.is_fault:
        return f"{words}the robot had a fault at {cause.time:.2f} s, during {where}: {cause.reason}"
    return f"{words}{where} failed at {cause.time:.2f} s: {cause.reason}"
