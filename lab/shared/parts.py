"""CPU time of the parts of a step, measured by wrapping the functions that it calls."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from time import perf_counter_ns, thread_time_ns
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

Functions: TypeAlias = Mapping[str, tuple[tuple[Any, str], ...]]
"""The functions of every part, as (owner, attribute) where they are looked up."""
Result = TypeVar("Result")


class PartTimer:
    """Measures the parts of a step in CPU time of the thread.

    Args:
        functions: of every part.
    """

    def __init__(self, functions: Functions) -> None:
        self._functions = functions
        self._now: dict[str, int] = {}
        self._inner = [0]
        self._steps: list[dict[str, int]] = []
        self._times: list[tuple[int, int]] = []

    def step(self, work: Callable[[], Result]) -> Result:
        """Do one step; its parts are measured only inside `measuring`."""
        self._now = dict.fromkeys(self._functions, 0)
        begun_wall, begun = perf_counter_ns(), thread_time_ns()
        result = work()
        total = thread_time_ns() - begun
        self._times.append((perf_counter_ns() - begun_wall, total))
        self._steps.append(self._now | {"rest": total - sum(self._now.values())})
        return result

    def medians(self) -> dict[str, float]:
        """Median time of every part, and of the rest of the step [µs]."""
        names = (*self._functions, "rest")
        return {name: float(np.median([s[name] for s in self._steps]) / 1e3) for name in names}

    def times_ns(self) -> npt.NDArray[np.float64]:
        """(2, N) wall-clock time and CPU time of every step [ns]."""
        return np.array(self._times, dtype=float).T

    def parts_ns(self, number: int) -> dict[str, int]:
        """CPU time of the parts of one step, and of its rest [ns]."""
        return self._steps[number]

    @contextmanager
    def measuring(self) -> Iterator[None]:
        """Measure the parts inside of this context."""
        places = [
            (part, *place) for part, functions in self._functions.items() for place in functions
        ]
        before = [(owner, name, getattr(owner, name)) for _, owner, name in places]
        for part, owner, name in places:
            setattr(owner, name, self._timed(part, getattr(owner, name)))
        try:
            yield
        finally:
            for owner, name, function in before:
                setattr(owner, name, function)

    def _timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function with its time added to the part, less that of measured functions inside."""

        def timed(*arguments: Any, **named: Any) -> Any:
            self._inner.append(0)
            begun = thread_time_ns()
            result = function(*arguments, **named)
            spent = thread_time_ns() - begun
            self._now[part] += spent - self._inner.pop()
            self._inner[-1] += spent
            return result

        return timed
