"""Grasping on the move: the same objects grasped standing and in passing."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.table import Table

from app.core import RunOptions, Summary, run_task
from lab.bench.pick_place import failure_causes
from lab.shared import fixed, paired_difference, percent, run_in_order, table

_TASKS = Path(__file__).parent / "tasks"
WAYS = {name: _TASKS / f"{name}.yaml" for name in ("standing", "in_passing")}
"""The two tasks, which differ only in the next goal and in what follows a miss."""


@dataclass(frozen=True, kw_only=True)
class Passing:
    """One run of one of both tasks."""

    way: str
    seed: int
    delivered: bool  # whether the object truly lies on the table ahead
    first: bool  # whether it was delivered at the first attempt, without any failure
    seconds: float
    contacts: int
    limit_violations: int


@dataclass(frozen=True, kw_only=True)
class PassingFigures:
    """All runs of one of both tasks."""

    way: str
    runs: int
    delivered: int
    first: int  # number of objects delivered at the first attempt
    time_mean_s: float | None  # of the runs that delivered; None without any
    contacts: int
    limit_violations: int


@dataclass(frozen=True, kw_only=True)
class Saving:
    """Time saved in passing over the seeds delivered both ways, as a share of the standing time."""

    pairs: int
    share: float
    interval: tuple[float, float]  # 95 %, by bootstrap over the seeds


def run_on_the_move(
    options: RunOptions,
    seeds: Sequence[int],
    done: Callable[[Summary], None],
    *,
    workers: int | str | None,
) -> list[Passing]:
    """Run both tasks for every seed: all standing runs, then all others."""
    wanted = [replace(options, tree=tree, seed=seed) for tree in WAYS.values() for seed in seeds]
    runs = run_in_order(_run, wanted, lambda run: done(run[0]), workers=workers, batch=1)
    return [passing for _, passing in runs]


def _run(options: RunOptions) -> tuple[Summary, Passing]:
    result = run_task(options)
    summary, failures = result.summary, failure_causes(result.folder)
    delivered = summary.placed == summary.objects != 0
    return summary, Passing(
        way=summary.task,
        seed=options.seed,
        delivered=delivered,
        first=delivered and summary.attempts == summary.objects and not failures,
        seconds=summary.duration_s,
        contacts=summary.contacts,
        limit_violations=summary.limit_violations,
    )


def saving(runs: Sequence[Passing]) -> Saving | None:
    """The time saved; None where no seed was delivered both ways."""
    standing, passing = (
        {run.seed: run.seconds for run in runs if run.way == way and run.delivered} for way in WAYS
    )
    both = sorted(standing.keys() & passing.keys())
    if not both:
        return None
    before = np.array([standing[seed] for seed in both])
    difference, low, high = paired_difference(before, np.array([passing[seed] for seed in both]))
    whole = float(before.mean())
    return Saving(pairs=len(both), share=difference / whole, interval=(low / whole, high / whole))


def passing_figures(runs: Sequence[Passing]) -> list[PassingFigures]:
    """Those of both tasks, in the order of `WAYS`."""
    return [_figures(way, [run for run in runs if run.way == way]) for way in WAYS]


def _figures(way: str, runs: Sequence[Passing]) -> PassingFigures:
    times = [run.seconds for run in runs if run.delivered]
    return PassingFigures(
        way=way,
        runs=len(runs),
        delivered=len(times),
        first=sum(run.first for run in runs),
        time_mean_s=float(np.mean(times)) if times else None,
        contacts=sum(run.contacts for run in runs),
        limit_violations=sum(run.limit_violations for run in runs),
    )


def on_the_move_table(figures: Sequence[PassingFigures]) -> Table:
    """One row for each way."""
    return table(
        "The same objects, standing and in passing (95 % intervals)",
        figures,
        {"way": lambda one: one.way.replace("_", " ")},
        {
            "delivered": lambda one: f"{one.delivered} of {one.runs}",
            "at the first attempt [%]": lambda one: percent(
                [True] * one.first + [False] * (one.runs - one.first)
            ),
            "mean time [s]": lambda one: fixed(one.time_mean_s, 2),
            "contacts": lambda one: one.contacts,
            "over limit": lambda one: one.limit_violations,
        },
    )
