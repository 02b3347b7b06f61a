"""The history of a run in words, a line an event."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from app.review.event_log import (
    FaultEvent,
    Log,
    LoggedEvent,
    NodeEvent,
    NowEvent,
    PauseEvent,
    ResumeEvent,
)
from app.review.timeline import Timeline
from app.task_time import in_words


def history(log: Log, spans: Timeline, pauses: Sequence[tuple[float, float]] = ()) -> Iterator[str]:
    """What the leaves did, which were halted, and faults and pauses, with times.

    Args:
        log: with the times that people are told.
        spans: the same as spans.
        pauses: when each began and ended [s].
    """
    lengths = iter([end - begin for begin, end in pauses])
    inner = {node.path.rpartition("/")[0] for node in log.nodes}
    running: dict[int, str] = {}
    last = [max((index, *spans.below(index))) for index in range(len(log.nodes))]
    for event in sorted(log.events, key=lambda event: _order(event, last)):
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
                yield f"{at}▶ went on after a pause of {in_words(next(lengths, 0.0))}"


def _order(event: LoggedEvent, last: Sequence[int]) -> tuple[float, int, int]:
    """Sort key: within a tick faults first, then nodes as they end, children first."""
    if isinstance(event, NodeEvent | NowEvent):
        return event.time, last[event.node], -event.node
    return event.time, -1, 0
