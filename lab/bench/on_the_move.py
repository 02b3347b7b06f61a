"""What it saves to grasp in passing: the same objects, once standing and once on the move."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path

import numpy as np
from rich.table import Table

from app.core import RunOptions, Summary, run_task
from lab.bench.failures import causes
from lab.bench.whole_tasks import run_tasks
from lab.shared import paired_difference, percent

_HERE = Path(__file__).parent
WAYS = {name: _HERE / f"{name}.yaml" for name in ("standing", "in_passing")}
"""The two tasks, which differ in nothing but `next_goal` and what follows a miss."""


@dataclass(frozen=True, kw_only=True)
class Passing:
    """One run of one of both tasks."""

    way: str
    seed: int
    brought: bool
    """Whether the object lies where it was to be brought, as the world tells."""
    first: bool
    """Whether the first closing of the fingers brought it, and nothing had failed before."""
    seconds: float
    contacts: int
    limit_violations: int


@dataclass(frozen=True, kw_only=True)
class PassingFigures:
    """All runs of one of both tasks."""

    way: str
    runs: int
    brought: int
    first: int
    """How many were brought at the first attempt."""
    time_mean_s: float | None
    """Of those that were brought; None of none."""
    contacts: int
    limit_violations: int


@dataclass(frozen=True, kw_only=True)
class Saving:
    """Of the time of a standing grasp, over the seeds that both ways brought to the table."""

    pairs: int
    share: float
    interval: tuple[float, float]
    """Of 95 %, by bootstrap over the seeds."""


def run_on_the_move(
    options: RunOptions,
    seeds: Iterable[int],
    done: Callable[[Summary], None],
    *,
    workers: int = 1,
    cluster: str | None = None,
) -> list[Passing]:
    """Run both tasks for every seed.

    Args:
        options: of each run, except for task and seed.
        seeds: of the object and the camera's noise.
        done: called after each run.
        workers: number of processes; 1 is this one.
        cluster: address of a dask.distributed scheduler to use instead.

    Returns:
        All standing runs, then all others, in the order of the seeds.

    Raises:
        KeyboardInterrupt: a person has ended a run, and with it the others.
    """
    chosen = list(seeds)
    wanted = [replace(options, tree=tree, seed=seed) for tree in WAYS.values() for seed in chosen]
    runs = run_tasks(_run, wanted, attrgetter("summary"), done, workers=workers, cluster=cluster)
    return [_passing(run) for run in runs]


@dataclass(frozen=True, kw_only=True)
class _Run:
    summary: Summary
    failures: int
    """Of leaves that move the robot."""


def _run(options: RunOptions) -> _Run:
    result = run_task(options)
    return _Run(summary=result.summary, failures=sum(causes(result.folder).values()))


def _passing(run: _Run) -> Passing:
    summary = run.summary
    brought = summary.placed == summary.objects > 0
    return Passing(
        way=summary.task,
        seed=summary.seed,
        brought=brought,
        first=brought and summary.attempts == summary.objects and not run.failures,
        seconds=summary.duration_s,
        contacts=summary.contacts,
        limit_violations=summary.limit_violations,
    )


def saving(runs: Sequence[Passing]) -> Saving | None:
    """What passing saves; None where no seed was brought both ways."""
    standing, passing = (
        {run.seed: run.seconds for run in runs if run.way == way and run.brought} for way in WAYS
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
    times = [run.seconds for run in runs if run.brought]
    return PassingFigures(
        way=way,
        runs=len(runs),
        brought=len(times),
        first=sum(run.first for run in runs),
        time_mean_s=float(np.mean(times)) if times else None,
        contacts=sum(run.contacts for run in runs),
        limit_violations=sum(run.limit_violations for run in runs),
    )


def on_the_move_table(runs: Sequence[Passing]) -> Table:
    """One row for each way."""
    table = Table(title="The same objects, standing and in passing (95 % intervals)")
    for column in ("way", "brought", "at the first attempt [%]", "mean time [s]", "contacts"):
        table.add_column(column, justify="left" if column == "way" else "right")
    table.add_column("over limit", justify="right")
    for of_way in passing_figures(runs):
        table.add_row(
            of_way.way.replace("_", " "),
            f"{of_way.brought} of {of_way.runs}",
            percent([run.first for run in runs if run.way == of_way.way]),
            "-" if of_way.time_mean_s is None else f"{of_way.time_mean_s:.2f}",
            str(of_way.contacts),
            str(of_way.limit_violations),
        )
    return table
