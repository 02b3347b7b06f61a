"""Grasping on the move: the same objects grasped standing and in passing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.table import Table

from app.core import RunOptions, Summary, run_task
from lab.bench.tasks import failure_causes, run_tasks
from lab.shared import Workers, paired_difference, percent

_TASKS = Path(__file__).parent / "tasks"
WAYS = {name: _TASKS / f"{name}.yaml" for name in ("standing", "in_passing")}
"""The two tasks, which differ only in the next goal and in what follows a miss."""


@dataclass(frozen=True, kw_only=True)
class Passing:
    """One run of one of both tasks."""

    way: str
    seed: int
    delivered: bool
    """Whether the object truly lies on the table ahead."""
    first: bool
    """Whether it was delivered at the first attempt, without any failure."""
    seconds: float
    contacts: int
    limit_violations: int


@dataclass(frozen=True, kw_only=True)
class PassingFigures:
    """All runs of one of both tasks."""

    way: str
    runs: int
    delivered: int
    first: int
    """Number of objects delivered at the first attempt."""
    time_mean_s: float | None
    """Of the runs that delivered; None without any."""
    contacts: int
    limit_violations: int


@dataclass(frozen=True, kw_only=True)
class Saving:
    """Time saved in passing over the seeds delivered both ways, as a share of the standing time."""

    pairs: int
    share: float
    interval: tuple[float, float]
    """95 %, by bootstrap over the seeds."""


@dataclass(frozen=True, kw_only=True)
class _Run:
    summary: Summary
    failures: int
    """Number of failed actions."""


def run_on_the_move(
    options: RunOptions,
    seeds: Iterable[int],
    done: Callable[[Summary], None],
    *,
    workers: Workers = 1,
) -> list[Passing]:
    """Run both tasks for every seed: all standing runs, then all others.

    Args:
        options: of each run, except for task and seed.
        seeds: of the object and the camera's noise.
        done: called after each run.
        workers: number of processes, or the address of a dask.distributed scheduler.

    Raises:
        KeyboardInterrupt: a run was interrupted; the others end as well.
    """
    chosen = list(seeds)
    wanted = [replace(options, tree=tree, seed=seed) for tree in WAYS.values() for seed in chosen]
    return [_passing(run) for run in run_tasks(_run, wanted, done, workers=workers)]


def _run(options: RunOptions) -> _Run:
    result = run_task(options)
    return _Run(summary=result.summary, failures=sum(failure_causes(result.folder).values()))


def _passing(run: _Run) -> Passing:
    summary = run.summary
    delivered = summary.placed == summary.objects > 0
    return Passing(
        way=summary.task,
        seed=summary.seed,
        delivered=delivered,
        first=delivered and summary.attempts == summary.objects and not run.failures,
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


def on_the_move_table(runs: Sequence[Passing]) -> Table:
    """One row for each way."""
    table = Table(title="The same objects, standing and in passing (95 % intervals)")
    columns = ("delivered", "at the first attempt [%]", "mean time [s]", "contacts", "over limit")
    for column in ("way", *columns):
        table.add_column(column, justify="left" if column == "way" else "right")
    for of_way in passing_figures(runs):
        table.add_row(
            of_way.way.replace("_", " "),
            f"{of_way.delivered} of {of_way.runs}",
            percent([run.first for run in runs if run.way == of_way.way]),
            "-" if of_way.time_mean_s is None else f"{of_way.time_mean_s:.2f}",
            str(of_way.contacts),
            str(of_way.limit_violations),
        )
    return table
