"""Times of repeated work."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from time import thread_time_ns
from typing import TypeVar

import numpy as np

Result = TypeVar("Result")


@dataclass(frozen=True)
class Timing:
    """Time of the thread for repeated work, which other processes do not lengthen [µs]."""

    name: str
    steps: int
    median: float
    p99: float


class Interleaved:
    """Times the work of several candidates on the same input.

    Their order is drawn again every time, so that none has warmer caches or a less busy computer.
    """

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._times: defaultdict[str, list[int]] = defaultdict(list)

    def __call__(self, works: Mapping[str, Callable[[], Result]]) -> Result:
        """Do the work of every candidate; returns the result of the first."""
        names, results = list(works), {}
        for index in self._rng.permutation(len(names)):
            name = names[index]
            begun = thread_time_ns()
            results[name] = works[name]()
            self._times[name].append(thread_time_ns() - begun)
        return results[names[0]]

    @property
    def steps(self) -> int:
        """How often each candidate has worked."""
        return min(map(len, self._times.values()), default=0)

    def timings(self, names: Iterable[str]) -> list[Timing]:
        """Of the candidates of these names."""
        return [
            Timing(name, len(times), *np.percentile(times, (50.0, 99.0)) / 1e3)
            for name, times in ((name, self._times[name]) for name in names)
        ]
