"""Experiment 3 of the paper: the main task over a range of seeds, and Table IV."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from rich.table import Table

from app.core import Instruments, MotionForm, RunOptions, Summary, Tick, run_task
from app.review import CarriedObject, TimeUse, read_run, time_use
from lab.bench.evaluation import cumulative_jerk
from lab.bench.tasks import failure_causes, run_tasks
from lab.shared import Workers, bootstrap, machine

_PAPER = (
    ("the paper, holistic", "100 of 100", "113", "5.2", "16.8"),
    ("the paper, planning", "", "", "15.6", "35.2"),
)

Interval = tuple[float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class PickPlaceRun:
    """One run of the task, and figures of its recorded motion."""

    motion: str
    """Holistic or planning."""
    summary: Summary
    base_speed: float
    """Limit of the base [m/s]."""
    reverse_speed: float
    """The same backwards [m/s]."""
    objects: Sequence[CarriedObject]
    reach_times: Sequence[float]
    """From the release of the object before to fingers closed on this one [s]."""
    pick_place_times: Sequence[float]
    """From the first attempt at an object, or the release of the one before, to its release [s]."""
    causes: dict[str, int]
    """Counts of the causes of failed actions."""
    distance: float
    """Path length of the base [m]."""
    stationary: float
    """Time in which neither base nor arm moves [s]."""
    duration: float
    """[s]."""
    jerk: float
    """Cumulative jerk of the tool [m/s^2]."""
    plans: Sequence[float]
    """Real time of each motion plan [s]."""


class _PlanTimes(Instruments):
    """Durations of the ticks in which a motion is planned; the next tick's report tells."""

    def __init__(self) -> None:
        self.seconds: list[float] = []
        self._planned = False

    def after(self, tick: Tick) -> None:
        if tick.report.planning and not self._planned:
            self.seconds.append(tick.seconds)
        self._planned = tick.report.planning


def run_pick_place(
    options: RunOptions,
    seeds: Iterable[int],
    done: Callable[[Summary], None],
    *,
    motions: Sequence[MotionForm] = (MotionForm.HOLISTIC,),
    workers: Workers = 1,
) -> list[PickPlaceRun]:
    """Run the task once for every seed and motion form.

    Args:
        options: of each run, except for seed and motion.
        seeds: of objects and camera noise.
        done: called after each run.
        motions: the motion forms, whose runs are returned one after the other.
        workers: number of processes, or the address of a dask.distributed scheduler.

    Raises:
        KeyboardInterrupt: a run was interrupted; the others end as well.
    """
    chosen = list(seeds)
    wanted = [replace(options, seed=seed, motion=motion) for motion in motions for seed in chosen]
    return run_tasks(_run, wanted, done, workers=workers)


def _run(options: RunOptions) -> PickPlaceRun:
    plans = _PlanTimes()
    result = run_task(options, instruments=plans)
    use, objects = time_use(result.folder), read_run(result.folder).summary.carried
    motion = use.motion
    return PickPlaceRun(
        motion=options.motion.value,
        summary=result.summary,
        base_speed=float(motion.robot.limits.base_twist[0]),
        reverse_speed=float(motion.robot.limits.base_reverse),
        objects=objects,
        reach_times=_reach_times(use, objects),
        pick_place_times=_pick_place_times(objects),
        causes=failure_causes(result.folder),
        distance=motion.distance,
        stationary=float(motion.steps[motion.stationary].sum()),
        duration=float(motion.times[-1] - motion.times[0]),
        jerk=cumulative_jerk(motion.tool, float(np.median(motion.steps))),
        plans=plans.seconds,
    )


def _pick_place_times(objects: Sequence[CarriedObject]) -> list[float]:
    done = [one for one in objects if one.placed is not None]
    ends = [one.placed or 0.0 for one in done]
    return [end - begin for begin, end in pairwise([done[0].begun, *ends])] if done else []


def _reach_times(use: TimeUse, objects: Sequence[CarriedObject]) -> list[float]:
    """The last grasp that closed before a release, from the release before or the beginning."""
    closed = sorted(one.end for one in use.stretches if one.node.kind == "grasp")
    ends = [one.placed for one in objects if one.placed is not None]
    times = []
    for begin, end in pairwise([float(use.motion.times[0]), *ends]):
        inside = [time for time in closed if begin < time < end]
        if inside:
            times.append(inside[-1] - begin)
    return times


@dataclass(frozen=True, kw_only=True)
class PickPlaceFigures:
    """All runs with one motion form; times in seconds, intervals of 95 %."""

    motion: str
    world: str
    base_speed: float
    """Limit of the base [m/s]."""
    reverse_speed: float
    """The same backwards [m/s]."""
    runs: int
    objects: int
    placed: int
    attempts: int
    """How often the fingers closed."""
    first_attempt_rate: float
    """Share of all objects that were placed at the first attempt."""
    grasp_time_mean_s: float | None
    """From the first image of an object, the hand above the container, to fingers closed."""
    grasp_time_interval_s: Interval | None
    reach_time_mean_s: float | None
    """From the release of the object before to fingers closed."""
    reach_time_interval_s: Interval | None
    pick_place_time_mean_s: float | None
    """From the release of the object before to its own."""
    pick_place_time_interval_s: Interval | None
    stationary_fraction: float
    """Share of the time in which neither base nor arm moves."""
    cumulative_jerk: float | None
    """Of the tool, for each object that was placed [m/s^2]."""
    distance_per_object_m: float | None
    """Path length of the base for each object that was placed."""
    failures_by_cause: dict[str, int]
    limit_violations: int
    contacts: int
    plans: int
    """Number of planned motions of the arm."""
    plan_seconds_median: float | None
    """Real time of a plan."""


def pick_place_figures(runs: Sequence[PickPlaceRun]) -> list[PickPlaceFigures]:
    """One for every motion form, in their order."""
    motions = list(dict.fromkeys(run.motion for run in runs))
    return [_figures([run for run in runs if run.motion == motion]) for motion in motions]


def _figures(runs: Sequence[PickPlaceRun]) -> PickPlaceFigures:
    summaries = [run.summary for run in runs]
    carried = [one for run in runs for one in run.objects if one.placed is not None]
    objects, number = sum(s.objects for s in summaries), len(carried)
    grasps = [one.grasp_time for one in carried]
    reaches = [time for run in runs for time in run.reach_times]
    cycles = [time for run in runs for time in run.pick_place_times]
    failures: Counter[str] = Counter()
    for run in runs:
        failures.update(run.causes)
    plans = [seconds for run in runs for seconds in run.plans]
    return PickPlaceFigures(
        motion=runs[0].motion,
        world=summaries[0].world,
        base_speed=runs[0].base_speed,
        reverse_speed=runs[0].reverse_speed,
        runs=len(runs),
        objects=objects,
        placed=sum(s.placed for s in summaries),
        attempts=sum(s.attempts for s in summaries),
        first_attempt_rate=sum(one.attempts == 1 for one in carried) / max(objects, 1),
        grasp_time_mean_s=_mean(grasps),
        grasp_time_interval_s=_interval(grasps),
        reach_time_mean_s=_mean(reaches),
        reach_time_interval_s=_interval(reaches),
        pick_place_time_mean_s=_mean(cycles),
        pick_place_time_interval_s=_interval(cycles),
        stationary_fraction=sum(r.stationary for r in runs) / max(sum(r.duration for r in runs), 1),
        cumulative_jerk=sum(run.jerk for run in runs) / number if number else None,
        distance_per_object_m=sum(run.distance for run in runs) / number if number else None,
        failures_by_cause=dict(failures.most_common()),
        limit_violations=sum(s.limit_violations for s in summaries),
        contacts=sum(s.contacts for s in summaries),
        plans=len(plans),
        plan_seconds_median=float(np.median(plans)) if plans else None,
    )


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _interval(values: Sequence[float]) -> Interval | None:
    return bootstrap(values) if len(values) > 1 else None


def pick_place_table(runs: Sequence[PickPlaceRun]) -> Table:
    """One row for every run."""
    first = runs[0].summary
    table = Table(title=f"{first.task}, {first.robot}, {first.world}, on {machine()['machine']}")
    columns = ("motion", "seed", "placed", "attempts", "time [s]", "grasp [s]")
    more = ("pick and place [s]", "limit violations", "contacts", "tick median / p99 [ms]")
    for column in (*columns, *more, "times real time"):
        table.add_column(column, justify="right")
    for run in runs:
        s = run.summary
        table.add_row(
            run.motion,
            str(s.seed),
            f"{s.placed} of {s.objects}",
            str(s.attempts),
            f"{s.duration_s:.0f}",
            _seconds(s.grasp_time_mean_s),
            _seconds(s.pick_place_time_mean_s),
            str(s.limit_violations),
            str(s.contacts),
            f"{s.tick_median_ms:.2f} / {s.tick_p99_ms:.2f}",
            f"{s.real_time_factor:.1f}",
        )
    return table


def table_iv(figures: Sequence[PickPlaceFigures]) -> Table:
    """Our motion forms below the paper's."""
    limits = f"base at most {figures[0].base_speed:g} m/s, back {figures[0].reverse_speed:g} m/s"
    table = Table(title=f"Experiment 3 (Table IV), {limits}, with 95 % intervals of the means")
    times = ("grasp [s]", "pick and place [s]", "set out to grasp [s]")
    others = ("still", "jerk per object", "driven per object [m]")
    for column in ("", "placed", "attempts", *times, *others):
        table.add_column(column, justify="right" if column else "left")
    for row in _PAPER:
        table.add_row(*row)
    for one in figures:
        table.add_row(
            f"{one.motion}, {one.world}",
            f"{one.placed} of {one.objects}",
            str(one.attempts),
            _seconds(one.grasp_time_mean_s, one.grasp_time_interval_s),
            _seconds(one.pick_place_time_mean_s, one.pick_place_time_interval_s),
            _seconds(one.reach_time_mean_s, one.reach_time_interval_s),
            f"{100.0 * one.stationary_fraction:.0f} %",
            "-" if one.cumulative_jerk is None else f"{one.cumulative_jerk:.0f}",
            "-" if one.distance_per_object_m is None else f"{one.distance_per_object_m:.1f}",
        )
    return table


def pick_place_notes(figures: Sequence[PickPlaceFigures]) -> list[str]:
    """Causes of failures, planning times, and ratios of the times of two motion forms."""
    notes = []
    for one in figures:
        for cause, count in one.failures_by_cause.items():
            notes.append(f"{one.motion}: {count} times {cause}")
        if one.plans:
            median = 1000.0 * (one.plan_seconds_median or 0.0)
            notes.append(f"{one.motion}: {one.plans} plans, median {median:.0f} ms of real time")
    if len(figures) == 2:
        first, second = figures
        for name in ("grasp_time_mean_s", "reach_time_mean_s", "pick_place_time_mean_s"):
            a, b = getattr(first, name), getattr(second, name)
            if a and b:
                notes.append(f"{name}: {second.motion} / {first.motion} = {b / a:.2f}")
    return notes


def _seconds(value: float | None, interval: Interval | None = None) -> str:
    if value is None:
        return "-"
    return f"{value:.1f}" + (f" ({interval[0]:.1f} to {interval[1]:.1f})" if interval else "")
