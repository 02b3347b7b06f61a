"""Times of repeated work: statistics and table."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan
from time import perf_counter_ns, thread_time_ns
from typing import TypeVar

import numpy as np
from rich.table import Table

from controller import Array
from lab.shared import machine

Result = TypeVar("Result")


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


class Interleaved:
    """Times the work of several candidates on the same input.

    Their order is drawn again every time, so that none has warmer caches or a less busy computer.
    """

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._times: defaultdict[str, list[tuple[int, int]]] = defaultdict(list)

    def __call__(self, works: Mapping[str, Callable[[], Result]]) -> Result:
        """Do the work of every candidate; returns the result of the first."""
        names, results = list(works), {}
        for index in self._rng.permutation(len(names)):
            name = names[index]
            wall, cpu = perf_counter_ns(), thread_time_ns()
            results[name] = works[name]()
            cpu, wall = thread_time_ns() - cpu, perf_counter_ns() - wall
            self._times[name].append((wall, cpu))
        return results[names[0]]

    @property
    def steps(self) -> int:
        """How often each candidate has worked."""
        return min(map(len, self._times.values()), default=0)

    def timings(self, names: Sequence[str], prefix: str = "") -> list[Timing]:
        """Of the candidates of these names."""
        times = {name: np.array(self._times[name], dtype=float).T for name in names}
        return [Timing.of(f"{prefix}{name}", *both) for name, both in times.items()]


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
