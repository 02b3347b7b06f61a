"""Whole tasks in worker processes, and the causes of the failures of their behaviours."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol, TypeVar

from app.core import EVENTS, End, RunOptions, Summary, read_events
from behaviours import LEAVES
from lab.shared import Workers, run_in_order

_QUESTIONS = ("region_empty",)
"""Leaves that answer a question, besides the conditions: their FAILURE means no."""
_NUMBER = re.compile(r"\d+(\.\d+)?")


class WithSummary(Protocol):
    """The result of a run."""

    @property
    def summary(self) -> Summary:
        """Of the run."""


R = TypeVar("R", bound=WithSummary)


def run_tasks(
    work: Callable[[RunOptions], R],
    options: Sequence[RunOptions],
    done: Callable[[Summary], None],
    *,
    workers: Workers,
) -> list[R]:
    """Run every task.

    Args:
        work: runs one; a function at module level.
        options: of each run.
        done: called after each run, in the order of completion.
        workers: number of processes, or the address of a dask.distributed scheduler.

    Returns:
        The results of `work`, in the order of `options`.

    Raises:
        KeyboardInterrupt: a run was interrupted; the others end as well.
    """

    def after(run: R) -> None:
        done(run.summary)
        if run.summary.outcome == End.INTERRUPTED.value:
            raise KeyboardInterrupt

    return run_in_order(work, options, after, workers=workers, batch=1)


def failure_causes(folder: Path) -> dict[str, int]:
    """Counts of the messages of failed actions of a run, without numbers, most frequent first."""
    nodes: list[dict[str, str]] = []
    found: Counter[str] = Counter()
    for event in read_events(folder / EVENTS):
        if event.event == "begin":
            nodes = list(event.fields["nodes"])
        if event.event != "node" or event.fields["status"] != "FAILURE":
            continue
        leaf = LEAVES.get(nodes[event.fields["node"]]["kind"])
        if leaf is not None and not leaf.is_condition and leaf.key not in _QUESTIONS:
            found[f"{leaf.key}: {_NUMBER.sub('#', str(event.fields['message']))}"] += 1
    return dict(found.most_common())
