"""Experiment 3 of the paper: the main task over a range of seeds, and Table IV."""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf
from operator import itemgetter
from pathlib import Path

import numpy as np
from rich.table import Table

from app.core import (
    STATES,
    Instruments,
    RunOptions,
    Setup,
    Summary,
    Tick,
    pick_place_times,
    run_task,
)
from app.review import NodeEvent, read_log
from behaviours import LEAVES
from controller import HolisticController, RobotModel
from lab.bench.planning import PlanningController
from lab.shared import bootstrap, fixed, machine, run_in_order, table
from robots import load_robot, with_base_speeds
from trees.language import TreeNode

_QUESTIONS = ("region_empty",)
"""Leaves that answer a question, besides the conditions: their FAILURE means no."""
_NUMBER = re.compile(r"\d+(\.\d+)?")
_TIMES = ("grasp [s]", "pick and place [s]")
_HEADS = ("placed", "attempts", *_TIMES, "driven per object [m]", "contacts", "over limit")
_PAPER = (
    ("the paper, holistic", "100 of 100", "113", "5.2", "16.8", "", "", ""),
    ("the paper, planning", "", "", "15.6", "35.2", "", "", ""),
)

Interval = tuple[float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class PickPlaceRun:
    """One run of the task, and figures of its recorded motion."""

    motion: str  # holistic or planning
    summary: Summary
    base_speed: float  # limit of the base [m/s]
    reverse_speed: float  # the same backwards [m/s]
    causes: dict[str, int]  # counts of the causes of failed actions
    distance: float  # path length of the base [m]


def run_pick_place(
    options: RunOptions,
    seeds: Sequence[int],
    done: Callable[[Summary], None],
    *,
    motions: Sequence[str],
    workers: int | str | None,
) -> list[PickPlaceRun]:
    """Run the task once for every seed and motion form, one form after the other."""
    wanted = [(motion, replace(options, seed=seed)) for motion in motions for seed in seeds]
    return run_in_order(_run, wanted, lambda run: done(run.summary), workers=workers, batch=1)


class _Planned(Instruments):
    """The baseline in place of the controller; a grasp is kept as it is first seen."""

    def controller(self, model: RobotModel) -> HolisticController:
        return PlanningController(model)

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        self._tracker = setup.context.vision.tracker

    def after(self, tick: Tick) -> None:
        self._tracker.lock_distance = inf


MOTIONS: dict[str, type[Instruments]] = {"holistic": Instruments, "planning": _Planned}
"""Ways to move, by name."""


def _run(wanted: tuple[str, RunOptions]) -> PickPlaceRun:
    motion, options = wanted
    result = run_task(options, instruments=MOTIONS[motion]())
    limits = with_base_speeds(
        load_robot(options.robot), options.base_speed, options.reverse_speed
    ).limits
    states = np.load(result.folder / STATES)
    return PickPlaceRun(
        motion=motion,
        summary=result.summary,
        base_speed=float(limits.base_twist[0]),
        reverse_speed=float(limits.base_reverse),
        causes=failure_causes(result.folder),
        distance=float(np.hypot(states[:-1, 4], states[:-1, 5]) @ np.diff(states[:, 0])),
    )


def failure_causes(folder: Path) -> dict[str, int]:
    """Counts of the messages of failed actions of a run, without numbers, most frequent first."""
    log, found = read_log(folder), Counter[str]()
    for event in log.events:
        if isinstance(event, NodeEvent) and event.status == "FAILURE":
            leaf = LEAVES.get(log.nodes[event.node].kind)
            if leaf is not None and not leaf.is_condition and leaf.key not in _QUESTIONS:
                found[f"{leaf.key}: {_NUMBER.sub('#', event.message)}"] += 1
    return dict(found.most_common())


@dataclass(frozen=True, kw_only=True)
class PickPlaceFigures:
    """All runs with one motion form; times in seconds, intervals of 95 %."""

    motion: str
    world: str
    base_speed: float  # limit of the base [m/s]
    reverse_speed: float  # the same backwards [m/s]
    runs: int
    objects: int
    placed: int
    attempts: int  # how often the fingers closed
    first_attempt_rate: float  # share of all objects that were placed at the first attempt
    grasp_time_mean_s: float | None
    """From the first image of an object, the hand above the container, to fingers closed."""
    grasp_time_interval_s: Interval | None
    pick_place_time_mean_s: float | None  # from the release of the object before to its own
    pick_place_time_interval_s: Interval | None
    distance_per_object_m: float | None  # path length of the base for each object that was placed
    failures_by_cause: dict[str, int]
    limit_violations: int
    contacts: int


def pick_place_figures(runs: Sequence[PickPlaceRun]) -> list[PickPlaceFigures]:
    """One for every motion form, in their order."""
    motions = list(dict.fromkeys(run.motion for run in runs))
    return [_figures([run for run in runs if run.motion == motion]) for motion in motions]


def _figures(runs: Sequence[PickPlaceRun]) -> PickPlaceFigures:
    summaries = [run.summary for run in runs]
    carried = [one for s in summaries for one in s.carried if one["placed"] is not None]
    objects, number = sum(s.objects or 0 for s in summaries), len(carried)
    grasps = [one["grasp_time"] for one in carried]
    cycles = [time for s in summaries for time in pick_place_times(s.carried)]
    failures: Counter[str] = Counter()
    for run in runs:
        failures.update(run.causes)
    return PickPlaceFigures(
        motion=runs[0].motion,
        world=summaries[0].world,
        base_speed=runs[0].base_speed,
        reverse_speed=runs[0].reverse_speed,
        runs=len(runs),
        objects=objects,
        placed=sum(s.placed or 0 for s in summaries),
        attempts=sum(s.attempts for s in summaries),
        first_attempt_rate=sum(one["attempts"] == 1 for one in carried) / max(objects, 1),
        grasp_time_mean_s=_mean(grasps),
        grasp_time_interval_s=_interval(grasps),
        pick_place_time_mean_s=_mean(cycles),
        pick_place_time_interval_s=_interval(cycles),
        distance_per_object_m=sum(run.distance for run in runs) / number if number else None,
        failures_by_cause=dict(failures.most_common()),
        limit_violations=sum(s.limit_violations for s in summaries),
        contacts=sum(s.contacts for s in summaries),
    )


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _interval(values: Sequence[float]) -> Interval | None:
    return bootstrap(values) if len(values) > 1 else None


def table_iv(figures: Sequence[PickPlaceFigures]) -> Table:
    """Our motion forms below the paper's."""
    limits = f"base at most {figures[0].base_speed:g} m/s, back {figures[0].reverse_speed:g} m/s"
    title = f"Experiment 3 (Table IV), {limits}, with 95 % intervals, on {machine()['machine']}"
    ours = [
        (
            f"{one.motion}, {one.world}",
            f"{one.placed} of {one.objects}",
            one.attempts,
            _seconds(one.grasp_time_mean_s, one.grasp_time_interval_s),
            _seconds(one.pick_place_time_mean_s, one.pick_place_time_interval_s),
            fixed(one.distance_per_object_m, 1),
            one.contacts,
            one.limit_violations,
        )
        for one in figures
    ]
    return table(
        title,
        (*_PAPER, *ours),
        {"": itemgetter(0)},
        {head: itemgetter(number) for number, head in enumerate(_HEADS, 1)},
    )


def pick_place_notes(figures: Sequence[PickPlaceFigures]) -> list[str]:
    """Causes of failures, and ratios of the times of two motion forms."""
    notes = [
        f"{one.motion}: {count} x {cause}"
        for one in figures
        for cause, count in one.failures_by_cause.items()
    ]
    if len(figures) == 2:
        first, second = figures
        for name in ("grasp_time_mean_s", "pick_place_time_mean_s"):
            a, b = getattr(first, name), getattr(second, name)
            if a and b:
                notes.append(f"{name}: {second.motion} / {first.motion} = {b / a:.2f}")
    return notes


def _seconds(value: float | None, interval: Interval | None) -> str:
    if value is None:
        return "-"
    return f"{value:.1f}" + (f" ({interval[0]:.1f} to {interval[1]:.1f})" if interval else "")
