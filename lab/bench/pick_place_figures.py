"""Table IV: what Experiment 3 comes to with each kind of motion, beside the paper's figures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from lab.bench.pick_place import PickPlaceRun

_RESAMPLES, _SEED = 2000, 0
_PAPER = (
    ("the paper, holistic", "100 of 100", "113", "5.2", "16.8"),
    ("the paper, planning", "", "", "15.6", "35.2"),
)

Interval = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class PickPlaceFigures:
    """All runs with one kind of motion; times in seconds, intervals of 95 %."""

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
    """Share of all objects that the first closing of the fingers brought."""
    grasp_time_mean_s: float | None
    """From the first look at an object to fingers closed, the hand being above the container."""
    grasp_time_interval_s: Interval | None
    reach_time_mean_s: float | None
    """From the release of the object before to fingers closed: the drive is included."""
    reach_time_interval_s: Interval | None
    pick_place_time_mean_s: float | None
    """From the release of the object before to its own."""
    pick_place_time_interval_s: Interval | None
    stationary_fraction: float
    """Share of the time in which neither base nor arm moves."""
    cumulative_jerk: float | None
    """Of the tool, for each object that was placed [m/s^2]."""
    distance_per_object_m: float | None
    """That the base drives for each object that was placed."""
    failures_by_cause: dict[str, int]
    limit_violations: int
    contacts: int
    plans: int
    """Motions of the arm that were planned."""
    plan_seconds_median: float | None
    """Real time that one took on this computer."""
    seconds_by_leaf: dict[str, dict[str, float]]
    """For each object that was placed: time of each kind of leaf, and how much of it still."""


def pick_place_figures(runs: Sequence[PickPlaceRun]) -> list[PickPlaceFigures]:
    """One for every kind of motion, in their order."""
    kinds = list(dict.fromkeys(run.motion for run in runs))
    return [_figures([run for run in runs if run.motion == kind]) for kind in kinds]


def _figures(runs: Sequence[PickPlaceRun]) -> PickPlaceFigures:
    summaries = [run.summary for run in runs]
    carried = [one for run in runs for one in run.objects if one.placed is not None]
    objects = sum(s.objects for s in summaries)
    grasps = [one.grasp_time for one in carried]
    reaches = [time for run in runs for time in run.reach_times]
    cycles = [time for run in runs for time in run.pick_place_times]
    failures: Counter[str] = Counter()
    for run in runs:
        failures.update(run.causes)
    plans = [seconds for run in runs for seconds in run.plans]
    number = len(carried)
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
        seconds_by_leaf=_by_leaf(runs, number),
    )


def _by_leaf(runs: Sequence[PickPlaceRun], number: int) -> dict[str, dict[str, float]]:
    leaves = [one for run in runs for one in run.leaves]
    found = {
        name: {
            "seconds": sum(one.seconds for one in leaves if one.name == name) / max(number, 1),
            "still": sum(one.waiting for one in leaves if one.name == name) / max(number, 1),
        }
        for name in dict.fromkeys(one.name for one in leaves)
    }
    return dict(sorted(found.items(), key=lambda item: -item[1]["seconds"]))


def table_iv(figures: Sequence[PickPlaceFigures]) -> Table:
    """Ours, kind by kind, below the paper's."""
    limits = f"base at most {figures[0].base_speed:g} m/s, back {figures[0].reverse_speed:g} m/s"
    table = Table(title=f"Experiment 3 (Table IV), {limits}, with 95 % intervals of the means")
    for column in (
        "",
        "placed",
        "attempts",
        "grasp [s]",
        "pick and place [s]",
        "set out to grasp [s]",
        "still",
        "jerk per object",
        "driven per object [m]",
    ):
        table.add_column(column, justify="right" if column else "left")
    for row in _PAPER:
        table.add_row(*row)
    for one in figures:
        table.add_row(
            f"{one.motion}, {one.world}",
            f"{one.placed} of {one.objects}",
            str(one.attempts),
            _with(one.grasp_time_mean_s, one.grasp_time_interval_s),
            _with(one.pick_place_time_mean_s, one.pick_place_time_interval_s),
            _with(one.reach_time_mean_s, one.reach_time_interval_s),
            f"{100.0 * one.stationary_fraction:.0f} %",
            "-" if one.cumulative_jerk is None else f"{one.cumulative_jerk:.0f}",
            "-" if one.distance_per_object_m is None else f"{one.distance_per_object_m:.1f}",
        )
    return table


def pick_place_notes(figures: Sequence[PickPlaceFigures]) -> list[str]:
    """Causes of failures, planning times, and how many times faster one is than the other."""
    notes = []
    for one in figures:
        for cause, count in one.failures_by_cause.items():
            notes.append(f"{one.motion}: {count} times {cause}")
        if one.plans:
            median = 1000.0 * (one.plan_seconds_median or 0.0)
            notes.append(f"{one.motion}: {one.plans} plans, median {median:.0f} ms of real time")
    by_motion = {one.motion: one for one in figures}
    if len(by_motion) == 2:
        first, second = figures
        for name in ("grasp_time_mean_s", "reach_time_mean_s", "pick_place_time_mean_s"):
            a, b = getattr(first, name), getattr(second, name)
            if a and b:
                notes.append(f"{name}: {second.motion} / {first.motion} = {b / a:.2f}")
    return notes


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _interval(values: Sequence[float]) -> Interval | None:
    """Of the mean: 95 % of the means of resamples, drawn with a seed."""
    if len(values) < 2:
        return None
    drawn = np.random.default_rng(_SEED).choice(values, (_RESAMPLES, len(values)))
    low, high = np.quantile(drawn.mean(axis=1), (0.025, 0.975))
    return float(low), float(high)


def _with(mean: float | None, interval: Interval | None) -> str:
    if mean is None:
        return "-"
    between = "" if interval is None else f" ({interval[0]:.1f} to {interval[1]:.1f})"
    return f"{mean:.1f}{between}"
