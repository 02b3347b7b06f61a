"""Time use of a run: by node, whether the robot moves, and what limits it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from app.review.event_log import Log, Node, read_log
from app.review.finished import read_run
from app.review.motion import Reason, RunMotion, read_motion
from app.review.timeline import timeline

_SHOWN = 0.05
"""Shorter durations are left out of the text [s]."""
_SHARE, _MOST, _WIDEST = 0.04, 3, 34


class Stretch(NamedTuple):
    """An interval in which a leaf ran, on the session's clock [s]."""

    node: Node
    begin: float
    end: float
    message: str


@dataclass(frozen=True, kw_only=True)
class NodeTime:
    """Time of one node."""

    name: str
    seconds: float
    base: float
    """Of them with the base moving, also together with the arm [s]."""
    arm: float
    """The same of the arm [s]."""
    waiting: float
    """With neither moving [s]."""
    reasons: Mapping[str, float]
    """By limit, the largest first [s]."""


@dataclass(frozen=True, kw_only=True)
class Cycle:
    """From the release of one object to that of the next, or a whole run."""

    number: int
    """From 1; 0 is the whole run."""
    nodes: Sequence[NodeTime]
    rest: NodeTime
    """All of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TimeUse:
    """Time use of a run."""

    motion: RunMotion
    stretches: Sequence[Stretch]
    cycles: Sequence[Cycle]
    """One for every object that was placed; without any, the whole run."""

    @property
    def typical(self) -> Cycle:
        """The cycle of median length."""
        ordered = sorted(self.cycles, key=lambda cycle: cycle.rest.seconds)
        return ordered[(len(ordered) - 1) // 2]

    def __str__(self) -> str:
        return "\n".join(_text(self))


def time_use(folder: Path) -> TimeUse:
    """Time use of a finished run, without pauses.

    Raises:
        DamagedRunError: its log or its motion cannot be read.
    """
    log, motion = read_log(folder), read_motion(folder)
    for begin, end in log.pauses:
        motion.steps[motion.between(begin, end)] = 0.0
    found = _stretches(log)
    first, last = float(motion.times[0]), float(motion.times[-1])
    carried = read_run(folder).summary.carried
    placed = [log.session_time(one.placed - log.began) for one in carried if one.placed is not None]
    if placed:
        spans = zip([first, *placed[:-1]], placed, strict=True)
        cycles = [_cycle(n, *span, found, motion) for n, span in enumerate(spans, start=1)]
    else:
        cycles = [_cycle(0, first, last, found, motion)]
    return TimeUse(motion=motion, stretches=found, cycles=cycles)


def _stretches(log: Log) -> list[Stretch]:
    """When each leaf ran, in the order of their ends."""
    run = timeline(log)
    spans = [one for node, rounds in run.rounds.items() if run.is_leaf(node) for one in rounds]
    spans = sorted((one for one in spans if one.seconds > 0.0), key=lambda one: one.end)
    return [Stretch(log.nodes[one.node], one.begin, one.end, one.message) for one in spans]


def _cycle(
    number: int, begin: float, end: float, found: Sequence[Stretch], motion: RunMotion
) -> Cycle:
    nodes: dict[str, list[Stretch]] = {}
    for one in sorted(found, key=lambda one: one.begin):
        if one.end > begin and one.begin < end:
            inside = one._replace(begin=max(one.begin, begin), end=min(one.end, end))
            nodes.setdefault(one.node.path, []).append(inside)
    times = []
    for some in nodes.values():
        last = max(some, key=lambda one: one.end)
        name = f"{last.node.name}: {last.message}"[:_WIDEST] if last.message else last.node.name
        times.append(_node_time(name, [one[1:3] for one in some], motion))
    return Cycle(number=number, nodes=times, rest=_node_time("all", [(begin, end)], motion))


def _node_time(name: str, some: Sequence[tuple[float, float]], motion: RunMotion) -> NodeTime:
    """Time of some intervals [s]."""
    chosen = np.zeros(len(motion.times), bool)
    for begin, end in some:
        chosen |= motion.between(begin, end)
    steps = np.where(chosen, motion.steps, 0.0)
    spent = np.bincount(motion.reasons, weights=steps, minlength=len(Reason))
    reasons = [(reason.value, float(s)) for reason, s in zip(Reason, spent, strict=True) if s > 0.0]
    return NodeTime(
        name=name,
        seconds=float(steps.sum()),
        base=float(steps[motion.base_moves].sum()),
        arm=float(steps[motion.arm_moves].sum()),
        waiting=float(steps[motion.stationary].sum()),
        reasons=dict(sorted(reasons, key=lambda one: -one[1])),
    )


def _text(use: TimeUse) -> Iterator[str]:
    cycle = use.typical
    length = cycle.rest.seconds
    if cycle.number:
        mean = np.mean([one.rest.seconds for one in use.cycles])
        of = f"Object {cycle.number} of {len(use.cycles)}, the one of median time"
        yield f"{of}: {length:.2f} s from the release before to its own; mean {mean:.2f} s"
    else:
        yield f"The whole run, in which nothing was placed: {length:.2f} s"
    yield ""
    width = max(len(one.name) for one in (*cycle.nodes, cycle.rest))
    yield f"  {'node':{width}}  {'time':>6}  {'base':>6}  {'arm':>6}  {'still':>6}  limited by"
    for one in (*(one for one in cycle.nodes if one.seconds >= _SHOWN), cycle.rest):
        figures = (one.seconds, one.base, one.arm, one.waiting)
        row = "  ".join(f"{value:6.2f}" for value in figures)
        yield f"  {one.name:{width}}  {row}  {_limits(one)}".rstrip()
    yield ""
    yield "  Seconds; base and arm may move at the same time. Everything at its limit is as fast as"
    yield "  this robot goes; what is still, or not at a limit, is what a task could save."


def _limits(one: NodeTime) -> str:
    """The largest limits, each with its share of the time."""
    shares = [(reason, spent / max(one.seconds, 1e-9)) for reason, spent in one.reasons.items()]
    some = [f"{reason} {100.0 * share:.0f} %" for reason, share in shares if share > _SHARE]
    return ", ".join(some[:_MOST])
