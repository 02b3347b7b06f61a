"""Times of repeated work: statistics, table, and the cost of the tree language."""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import isnan, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter_ns, thread_time_ns
from typing import Any, cast

import numpy as np
from py_trees.common import Status
from rich.table import Table

from behaviours import Condition, Context, Leaf
from controller import Array
from hw import SimClock
from lab.shared import machine
from trees.language import build, load, nodes_in_order

NODES_READ = 200
NODES_TICKED = 31
_ROUNDS = 50
"""How often the file is read; the tree is ticked a hundred times as often."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Wall-clock and CPU time of repeated work [µs]."""

    name: str
    steps: int
    median: float
    p95: float
    p99: float
    worst: float
    cpu_median: float = nan
    """CPU time of the thread, which other processes do not lengthen; NaN if not measured."""
    cpu_p95: float = nan
    cpu_p99: float = nan
    cpu_worst: float = nan

    @classmethod
    def of(cls, name: str, wall_ns: Array, cpu_ns: Array | None = None) -> Timing:
        """From the times of all steps."""
        values: dict[str, float] = {}
        for prefix, times in (("", wall_ns), ("cpu_", cpu_ns)):
            if times is not None:
                marks = np.percentile(times, (50.0, 95.0, 99.0, 100.0)) / 1e3
                names = (f"{prefix}{name}" for name in ("median", "p95", "p99", "worst"))
                values |= dict(zip(names, marks.tolist(), strict=True))
        return cls(name=name, steps=len(wall_ns), **values)


@dataclass(frozen=True, kw_only=True)
class TimingReport:
    """Times of one part of `bench timing`, and lines below their table."""

    timings: Sequence[Timing]
    notes: Sequence[str] = ()
    figures: dict[str, Any] = field(default_factory=dict)
    """Further figures for the JSON file."""


def timing_table(timings: Sequence[Timing]) -> Table:
    """One row for each."""
    table = Table(title=f"Times in µs, on {machine()['machine']}", title_justify="left")
    columns = ("steps", "median", "p95", "p99", "worst", "CPU median", "CPU p95", "CPU p99")
    for name in ("", *columns):
        table.add_column(name, justify="right" if name else "left")
    for t in timings:
        numbers = (t.median, t.p95, t.p99, t.worst, t.cpu_median, t.cpu_p95, t.cpu_p99)
        table.add_row(t.name, str(t.steps), *("-" if isnan(x) else f"{x:.0f}" for x in numbers))
    return table


class Holds(Condition):
    """A condition that always succeeds."""

    key = "holds"

    def update(self) -> Status:
        """One tick."""
        return self.success("yes")


class Works(Leaf):
    """An action that keeps running.

    Args:
        effort: not used.
        patience_s: not used.
    """

    key = "works"
    moves = False

    def __init__(
        self, name: str, context: Context, *, effort: float = 1.0, patience_s: float = 2.0
    ) -> None:
        super().__init__(name, context)

    def update(self) -> Status:
        """One tick."""
        return self.running("working")


_LEAVES: dict[str, type[Leaf]] = {leaf.key: leaf for leaf in (Holds, Works)}


class _ContextPart:
    """The part of a context that these leaves use."""

    clock = SimClock()


def _large_task() -> str:
    """A file of `NODES_READ` nodes, one composite for every four leaves."""
    part = (
        "    - name: part {}\n      retry: 3\n      timeout_s: 10\n      sequence:\n"
        "        - works: {{effort: 0.5, patience_s: 1.5}}\n        - holds\n"
        "        - works: {{effort: $effort}}\n        - {{invert: true, holds: }}\n"
    )
    parts = "".join(part.format(number) for number in range(NODES_READ // 5))
    return f"task: large\nparams: {{effort: {{default: 2.0}}}}\ntree:\n  sequence:\n{parts}"


def _busy_task() -> str:
    """A file whose tree has `NODES_TICKED` nodes, all of which are ticked in every tick."""
    guarded = "    - reactive_sequence: [holds, holds, holds, holds, works]\n"
    return f"task: busy\ntree:\n  parallel:\n{guarded * (NODES_TICKED // 6)}"


def time_tree() -> TimingReport:
    """Time reading a file of 200 nodes, and a tick of a tree of 31 nodes."""
    with TemporaryDirectory() as folder:
        large, busy = Path(folder) / "large.yaml", Path(folder) / "busy.yaml"
        large.write_text(_large_task(), encoding="utf-8")
        busy.write_text(_busy_task(), encoding="utf-8")
        root = build(load(busy, leaves=_LEAVES), cast(Context, _ContextPart()))
        assert len(nodes_in_order(root)) == NODES_TICKED
        timings = [
            _timed(
                f"read a file of {NODES_READ} nodes", lambda: load(large, leaves=_LEAVES), _ROUNDS
            ),
            _timed(f"tick a tree of {NODES_TICKED} nodes", root.tick_once, 100 * _ROUNDS),
        ]
    return TimingReport(timings=timings)


def _timed(name: str, work: Callable[[], object], rounds: int) -> Timing:
    work()
    wall, cpu = np.empty(rounds), np.empty(rounds)
    gc.collect()
    for number in range(rounds):
        begun, begun_cpu = perf_counter_ns(), thread_time_ns()
        work()
        cpu[number] = thread_time_ns() - begun_cpu
        wall[number] = perf_counter_ns() - begun
    return Timing.of(name, wall, cpu)
