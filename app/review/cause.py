"""Earliest cause of the failure that ended a run.

A tree that gives up has failed several times: retries, fallbacks, faults of the robot. From the
node that failed the search goes down and back in time, past what a later child has answered:

| node | cause |
|---|---|
| `retry`, `forever` | the first of the attempts that failed in a row |
| `fallback` | the last child that tried something, which a condition does not |
| `parallel` | the child that failed first |
| `until` | the work, not the condition |
| `timeout` | the first failed attempt below it, or else the timeout |
| other branches | the child that failed last: those before it had succeeded |
| a leaf | the robot's fault, if it had one while the leaf ran |
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

from app.review.timeline import Span, Timeline
from behaviours import LEAVES
from trees.language import LeafType, describe_leaves

_AGAIN = ("retry", "forever")
_NUMBER = re.compile(r"-?\d+(\.\d+)?")
_TIMES = ", # times in a row"
"""Added by `forever` to the message of the failure with which it gives up."""

_WORDS = (
    (r"emergency stop", "emergency stop"),
    (r"battery", "battery"),
    (r"closed on nothing|nothing held|nothing (left )?to place", "held nothing"),
    (r"fingers (did not move|still move|stopped)|not let go", "the gripper does not work"),
    (
        r"the arm has no posture|the hand reaches|below the floor|would be inside|: inside "
        r"|no stance|no way for the base|would stand in|out of reach",
        "out of reach",
    ),
    (r"camera frame|frames come|depth was measured|same in every pixel|is not seen", "no picture"),
    (r"^no grasp for", "no grasp found"),
    (r"no place free", "no place free"),
    (r"^not done (within|after)|^not at .* after", "out of time"),
    (r"stuck|^arm stopped|^not at ", "not reached"),
    (r"does not do what it is commanded|does not answer", "the robot does not obey"),
    (r"relocalised|certain where it is", "lost its place"),
)
"""Topics of messages, in a word or two; the first match counts."""


@dataclass(frozen=True, kw_only=True)
class Cause:
    """The earliest cause of a failure."""

    time: float  # of the task [s]
    node: int | None  # where; None if no node ran
    reason: str
    topic: str  # the topic in a word or two; empty if unknown
    is_fault: bool = False
    answered: tuple["Cause", ...] = ()  # failures before, after which a `fallback` went on


def topic_of(reason: str) -> str:
    """Topic of a message in a word or two; empty if unknown."""
    return next((words for pattern, words in _WORDS if re.search(pattern, reason)), "")


def cause_of(run: Timeline, span: Span) -> Cause:
    """Why a round of a node failed."""
    answered: list[Span] = []
    cause = _cause(run, _origin(run, span, answered))
    return replace(cause, answered=tuple(_cause(run, _origin(run, one)) for one in answered))


def first_setback(run: Timeline) -> Cause | None:
    """The first failure of the attempts in progress at the end; None if there is none."""
    failed: list[Span] = []
    for node, rounds in run.rounds.items():
        if run.nodes[node].kind in _AGAIN and rounds[-1].status == "RUNNING":
            failed += _attempts(run, rounds[-1])
    return cause_of(run, min(failed, key=lambda span: span.end)) if failed else None


def fault_cause(run: Timeline) -> Cause | None:
    """The fault that the robot had at the end, from its beginning; None if it had none."""
    standing = [fault for fault in run.faults if fault.end == float("inf")]
    if not standing:
        return None
    first = standing[0]
    for fault in reversed(run.faults):  # faults that followed each other without a gap are one
        if fault.end == first.begin:
            first = fault
    return _of_fault(run, first.begin, first.text)


def _cause(run: Timeline, span: Span) -> Cause:
    """The failure of a leaf, or the fault of the robot behind it."""
    for fault in run.faults:
        if fault.begin <= span.end and fault.end >= span.begin:
            return _of_fault(run, fault.begin, fault.text)
    return Cause(time=span.end, node=span.node, reason=span.message, topic=topic_of(span.message))


def _of_fault(run: Timeline, time: float, text: str) -> Cause:
    words = topic_of(text) or "a fault of the robot"
    return Cause(time=time, node=run.leaf_at(time), reason=text, topic=words, is_fault=True)


def _origin(run: Timeline, span: Span, answered: list[Span] | None = None) -> Span:
    """The round of the leaf, or of the modifier, in which a failure began.

    Failures on the way that a `fallback` has answered by another child are added to `answered`.
    """
    failed = _failed_children(run, span)
    match run.nodes[span.node].kind:
        case kind if kind in _AGAIN:
            failed = _attempts(run, span)
            chosen = failed[0] if failed else None
        case "fallback":
            tried = [one for one in failed if not _is_question(run, one)]
            asked = [one for one in failed if run.nodes[one.node].kind != "force_failure"]
            chosen = next(iter([*tried[-1:], *asked[-1:], *failed[-1:]]), None)
            if answered is not None:
                answered += tried[:-1]
        case "parallel":
            chosen = failed[0] if failed else None
        case "until":
            work = [one for one in failed if one.node != run.children(span.node)[0]]
            chosen = work[-1] if work else failed[-1] if failed else None
        case "timeout" if not failed:
            chosen = _setback_below(run, span)
        case _:
            chosen = failed[-1] if failed else None
    return span if chosen is None else _origin(run, chosen, answered)


def _failed_children(run: Timeline, span: Span) -> list[Span]:
    failed = [
        one
        for child in run.children(span.node)
        for one in run.within(span, child)
        if one.status == "FAILURE"
    ]
    return sorted(failed, key=lambda one: one.end)


def _attempts(run: Timeline, span: Span) -> list[Span]:
    """The failed attempts of a node that tries again; those before the last success are over."""
    failed = _failed_children(run, span)
    if run.nodes[span.node].kind != "forever" or not failed:
        return failed
    last = _likeness(run, failed[-1])
    in_a_row: list[Span] = []
    for one in reversed(failed):
        if _likeness(run, one) != last:
            break
        in_a_row.insert(0, one)
    return in_a_row


def _likeness(run: Timeline, span: Span) -> tuple[int, str]:
    """Key for failures with the same reason, except for figures."""
    origin = _origin(run, span)
    return origin.node, _NUMBER.sub("#", origin.message).removesuffix(_TIMES)


def _setback_below(run: Timeline, span: Span) -> Span | None:
    """The first failed attempt of what was running below a node when its time was over."""
    below = (node for node in run.below(span.node) if run.nodes[node].kind in _AGAIN)
    rounds = [one for node in below for one in run.within(span, node) if one.end == span.end]
    failed = [attempt for one in rounds for attempt in _attempts(run, one)]
    return min(failed, key=lambda one: one.end, default=None)


def _is_question(run: Timeline, span: Span) -> bool:
    """Whether it was only a condition, or was forced to fail."""
    if run.nodes[span.node].kind == "force_failure":
        return not _failed_children(run, span)
    return _asks(run, span.node)


def _asks(run: Timeline, node: int) -> bool:
    """Whether all that a node does is to ask conditions."""
    kind, leaves = run.nodes[node].kind, _leaves()
    if kind in ("sequence", "fallback", "not"):
        return all(_asks(run, child) for child in run.children(node))
    if kind in leaves:
        return leaves[kind].is_condition
    lasting = (one.seconds > 0.0 for one in run.rounds.get(node, ()))
    return run.is_leaf(node) and not any(lasting)  # of a package


@cache
def _leaves() -> Mapping[str, LeafType]:
    return describe_leaves(LEAVES)
