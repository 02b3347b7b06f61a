"""Time use of a run: by node, whether the robot moves, and what limits it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from app.core import SUMMARY
from app.review.event_log import DamagedRunError, Log, Node, read_log
from app.review.motion import Reason, RunMotion, read_motion
from app.review.timeline import timeline

_SHOWN = 0.05
"""Shorter durations are left out of the text [s]."""
_SHARE = 0.04
_MOST = 3
_WIDEST = 34
_Seconds = Annotated[float, Field(ge=0.0, le=1e9)]


class CarriedObject(BaseModel):
    """Times of one object in a summary, since the session began, without pauses [s]."""

    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)

    begun: _Seconds
    attempts: int
    grasp_time: _Seconds
    placed: _Seconds | None


class _Carried(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)

    carried: list[CarriedObject] = []


class Stretch(NamedTuple):
    """An interval in which a leaf ran, on the session's clock [s]."""

    node: Node
    begin: float
    end: float
    message: str = ""


@dataclass(frozen=True, kw_only=True)
class NodeTime:
    """Time of one node."""

    name: str
    message: str
    count: int
    seconds: float
    base: float
    """Of them with the base moving, also together with the arm [s]."""
    arm: float
    """The same of the arm [s]."""
    waiting: float
    """With neither moving [s]."""
    reasons: Mapping[str, float]
    """By limit [s]."""


@dataclass(frozen=True, kw_only=True)
class Cycle:
    """From the release of one object to that of the next, or a whole run."""

    number: int
    """From 1; 0 is the whole run."""
    begin: float
    end: float
    nodes: Sequence[NodeTime]
    rest: NodeTime


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
    found = stretches(log)
    placed = [
        log.session_time(one.placed - log.began)
        for one in carried_objects(folder)
        if one.placed is not None
    ]
    spans = list(zip([float(motion.times[0]), *placed], placed, strict=False))
    if not spans:
        spans = [(float(motion.times[0]), float(motion.times[-1]))]
    cycles = [
        _cycle(number if placed else 0, begin, end, found, motion)
        for number, (begin, end) in enumerate(spans, start=1)
    ]
    return TimeUse(motion=motion, stretches=found, cycles=cycles)


def carried_objects(folder: Path) -> list[CarriedObject]:
    """The objects in the summary of a run; none if there is no summary.

    Raises:
        DamagedRunError: it cannot be read.
    """
    try:
        text = (folder / SUMMARY).read_text(encoding="utf-8")
        return _Carried.model_validate_json(text).carried
    except FileNotFoundError:
        return []
    except (OSError, ValueError, ValidationError) as error:
        raise DamagedRunError(f"{folder / SUMMARY}: cannot be read") from error


def stretches(log: Log) -> list[Stretch]:
    """When each leaf ran, in the order of their ends."""
    run = timeline(log)
    spans = [one for node, rounds in run.rounds.items() if run.is_leaf(node) for one in rounds]
    spans = sorted((one for one in spans if one.seconds > 0.0), key=lambda one: one.end)
    return [Stretch(log.nodes[one.node], one.begin, one.end, one.message) for one in spans]


def _cycle(
    number: int, begin: float, end: float, found: Sequence[Stretch], motion: RunMotion
) -> Cycle:
    inside = [
        one._replace(begin=max(one.begin, begin), end=min(one.end, end))
        for one in found
        if one.end > begin and one.begin < end
    ]
    names = dict.fromkeys(one.node.path for one in sorted(inside, key=lambda one: one.begin))
    title = {one.node.path: one.node.name for one in inside}
    return Cycle(
        number=number,
        begin=begin,
        end=end,
        nodes=[
            node_time(title[path], [one for one in inside if one.node.path == path], motion)
            for path in names
        ],
        rest=node_time("all", [Stretch(Node(path="", name="", kind=""), begin, end)], motion),
    )


def node_time(name: str, some: Sequence[Stretch], motion: RunMotion) -> NodeTime:
    """Time of some intervals."""
    chosen = np.zeros(len(motion.times), bool)
    for one in some:
        chosen |= motion.between(one.begin, one.end)
    steps = np.where(chosen, motion.steps, 0.0)
    spent = np.bincount(motion.reasons, weights=steps, minlength=len(Reason))
    reasons = {reason.value: float(s) for reason, s in zip(Reason, spent, strict=True) if s > 0.0}
    return NodeTime(
        name=name,
        message=some[-1].message if some else "",
        count=len(some),
        seconds=float(steps.sum()),
        base=float(steps[motion.base_moves].sum()),
        arm=float(steps[motion.arm_moves].sum()),
        waiting=float(steps[motion.stationary].sum()),
        reasons=dict(Counter(reasons).most_common()),
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
    width = max(len(_name(one)) for one in (*cycle.nodes, cycle.rest))
    yield f"  {'node':{width}}  {'time':>6}  {'base':>6}  {'arm':>6}  {'still':>6}  limited by"
    for one in (*(one for one in cycle.nodes if one.seconds >= _SHOWN), cycle.rest):
        figures = (one.seconds, one.base, one.arm, one.waiting)
        row = "  ".join(f"{value:6.2f}" for value in figures)
        yield f"  {_name(one):{width}}  {row}  {_limits(one)}".rstrip()
    yield ""
    yield "  Seconds; base and arm may move at the same time. Everything at its limit is as fast as"
    yield "  this robot goes; what is still, or not at a limit, is what a task could save."


def _name(one: NodeTime) -> str:
    return f"{one.name}: {one.message}"[:_WIDEST] if one.message else one.name


def _limits(one: NodeTime) -> str:
    """The largest limits, each with its share of the time."""
    least = _SHARE * one.seconds
    some = [(reason, spent / one.seconds) for reason, spent in one.reasons.items() if spent > least]
    return ", ".join(f"{reason} {100.0 * share:.0f} %" for reason, share in some[:_MOST])
