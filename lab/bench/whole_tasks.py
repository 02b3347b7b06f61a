"""Whole tasks, run side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from app.core import End, RunOptions, Summary
from lab.shared import run_all

R = TypeVar("R")


def run_tasks(
    work: Callable[[RunOptions], R],
    wanted: Sequence[RunOptions],
    summary_of: Callable[[R], Summary],
    done: Callable[[Summary], None],
    *,
    workers: int,
    cluster: str | None,
) -> list[R]:
    """Run every task that is wanted.

    Args:
        work: runs one; a function at module level.
        wanted: the options of each run.
        summary_of: the summary of a run.
        done: called after each run, in the order of their ends.
        workers: number of processes; 1 is this one.
        cluster: address of a dask.distributed scheduler to use instead.

    Returns:
        What `work` made of them, in the order of `wanted`.

    Raises:
        KeyboardInterrupt: a person has ended a run, and with it the others.
    """
    runs: dict[int, R] = {}
    for number, run in run_all(work, wanted, workers=workers, cluster=cluster, batch=1):
        runs[number] = run
        summary = summary_of(run)
        done(summary)
        if summary.outcome == End.INTERRUPTED.value:
            raise KeyboardInterrupt
    return [runs[number] for number in range(len(wanted))]
