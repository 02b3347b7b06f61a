"""The main task over a range of seeds: objects placed, attempts and times."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, replace

from rich.table import Table

from app.core import RunOptions, Summary, run_task
from app.lab import machine
from app.lab.bench.whole_tasks import run_tasks


def run_pick_place(
    options: RunOptions,
    seeds: Iterable[int],
    done: Callable[[Summary], None],
    *,
    workers: int = 1,
    cluster: str | None = None,
) -> list[Summary]:
    """Run the task once for every seed.

    Args:
        options: of each run, except for the seed.
        seeds: of objects and camera noise.
        done: called after each run.
        workers: number of processes; 1 is this one.
        cluster: address of a dask.distributed scheduler to use instead.

    Returns:
        The summaries in the order of the seeds.

    Raises:
        KeyboardInterrupt: a person has ended a run, and with it the others.
    """
    runs = [replace(options, seed=seed) for seed in seeds]
    return run_tasks(_run, runs, _itself, done, workers=workers, cluster=cluster)


def _run(options: RunOptions) -> Summary:
    return run_task(options).summary


def _itself(summary: Summary) -> Summary:
    return summary


def pick_place_table(summaries: list[Summary]) -> Table:
    """One row for every seed, as in the README."""
    table = Table(title=f"{summaries[0].task}, {summaries[0].robot}, on {machine()['machine']}")
    for column in (
        "seed",
        "placed",
        "attempts",
        "time [s]",
        "grasp [s]",
        "pick and place [s]",
        "limit violations",
        "contacts",
        "tick median / p99 [ms]",
        "times real time",
    ):
        table.add_column(column, justify="right")
    for s in summaries:
        table.add_row(
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


def pick_place_json(summaries: list[Summary]) -> str:
    """The summaries and the machine they were measured on, as one JSON object."""
    return json.dumps({"about": machine(), "runs": [asdict(s) for s in summaries]}, indent=2)


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
