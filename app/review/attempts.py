"""Attempts of a run, and the leaves that took its time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from app.review.cause import Cause, cause_of, topic_of
from app.review.timeline import Span, Timeline

_MOST_LEAVES = 5


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """One round of something that is tried again."""

    number: int
    what: str
    begin: float
    end: float
    result: str
    cause: Cause | None
    """The cause of its failure; None if it succeeded."""


@dataclass(frozen=True, kw_only=True)
class LeafTime:
    """A leaf, and its total time [s]."""

    name: str
    seconds: float
    rounds: int


def attempts(run: Timeline) -> list[Attempt]:
    """The rounds of everything below a `retry`, in order; of `forever` only the failed ones."""
    spans: list[Span] = []
    for node, kind in enumerate(one.kind for one in run.nodes):
        if kind not in ("retry", "forever"):
            continue
        for child in run.children(node):
            rounds = run.rounds.get(child, ())
            spans += [one for one in rounds if kind == "retry" or one.status == "FAILURE"]
    spans.sort(key=lambda span: (span.begin, span.node))
    return [_attempt(run, number, span) for number, span in enumerate(spans, start=1)]


def _attempt(run: Timeline, number: int, span: Span) -> Attempt:
    cause = cause_of(run, span) if span.status == "FAILURE" else None
    endings = {"SUCCESS": "done", "INVALID": "halted", "RUNNING": "under way"}
    result = endings.get(span.status, "")
    if cause is not None:
        where = "" if cause.node is None else f"{run.nodes[cause.node].name}: "
        words = topic_of(cause.reason)
        result = f"{words or 'failed'}: {where}{cause.reason}"
    return Attempt(
        number=number,
        what=run.nodes[span.node].name,
        begin=span.begin,
        end=span.end,
        result=result,
        cause=cause,
    )


def longest_leaves(run: Timeline) -> list[LeafTime]:
    """The leaves that took the most time, the longest first."""
    found = [
        LeafTime(
            name=_short_path(run.nodes[node].path),
            seconds=sum(span.seconds for span in rounds),
            rounds=sum(span.seconds > 0.0 for span in rounds),
        )
        for node, rounds in run.rounds.items()
        if run.is_leaf(node)
    ]
    found = [one for one in found if one.seconds > 0.0]
    return sorted(found, key=lambda one: -one.seconds)[:_MOST_LEAVES]


def attempts_text(found: Sequence[Attempt], most: int = 12) -> list[str]:
    """The table, a line per attempt; the middle of a long one is left out."""
    lines = [f"  {'#':>3}  {'from':>8}  {'took':>7}  what came of it"]
    for one in found:
        took = f"{one.end - one.begin:.1f} s"
        lines.append(f"  {one.number:>3}  {one.begin:>6.1f} s  {took:>7}  {one.what}: {one.result}")
    if len(lines) > most + 1:
        half = most // 2
        left_out = len(lines) - 1 - 2 * half
        lines = [*lines[: half + 1], f"       ... {left_out} more ...", *lines[-half:]]
    return lines


def leaf_times_text(found: Sequence[LeafTime], total: float) -> list[str]:
    """The table of leaves, a line each."""
    width = max((len(one.name) for one in found), default=0)
    return [
        f"  {one.name:{width}}  {one.seconds:>7.1f} s  "
        f"{100.0 * one.seconds / max(total, 1e-9):>3.0f} %  {one.rounds} rounds"
        for one in found
    ]


def _short_path(path: str) -> str:
    """The end of a path: the node and its parent."""
    return " > ".join(path.split("/")[-2:])
