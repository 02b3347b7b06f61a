"""Times of repeated work."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from time import perf_counter_ns, thread_time_ns
from typing import TypeVar

import numpy as np

from config.arrays import Array

Result = TypeVar("Result")


@dataclass(frozen=True)
class Timing:
    """Wall-clock and CPU time of repeated work [µs]."""

    name: str
    steps: int
    median: float
    p95: float
    p99: float
    worst: float
    cpu_median: float  # of the thread, which other processes do not lengthen
    cpu_p95: float
    cpu_p99: float
    cpu_worst: float


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

    def timings(self, names: Iterable[str]) -> list[Timing]:
        """Of the candidates of these names."""
        return [_timing(name, np.array(self._times[name])) for name in names]


def _timing(name: str, wall_and_cpu_ns: Array) -> Timing:
    marks = np.percentile(wall_and_cpu_ns, (50.0, 95.0, 99.0, 100.0), axis=0) / 1e3
    return Timing(name, len(wall_and_cpu_ns), *marks.T.ravel().tolist())
