"""Where the time of a step goes: the functions that it is made of, timed while they run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from time import thread_time_ns
from typing import Any, TypeAlias, TypeVar

import numpy as np

Functions: TypeAlias = Mapping[str, tuple[tuple[Any, str], ...]]
"""The functions of every part, by where they are looked up."""
Answer = TypeVar("Answer")


class PartTimer:
    """Notes how long the parts of a step take, in processor time of the thread.

    Args:
        functions: what the parts are.
    """

    def __init__(self, functions: Functions) -> None:
        self._functions = functions
        self._now: dict[str, int] = {}
        self._inner = [0]
        self._steps: list[dict[str, int]] = []

    def step(self, work: Callable[[], Answer]) -> Answer:
        """Do one step; its parts are only noted while `watching`."""
        self._now = dict.fromkeys(self._functions, 0)
        begun = thread_time_ns()
        answer = work()
        total = thread_time_ns() - begun
        self._steps.append(self._now | {"rest": total - sum(self._now.values())})
        return answer

    def medians(self) -> dict[str, float]:
        """Median time of every part [µs]."""
        names = (*self._functions, "rest")
        return {name: float(np.median([s[name] for s in self._steps]) / 1e3) for name in names}

    @contextmanager
    def watching(self) -> Iterator[None]:
        """The parts are timed as long as this lasts."""
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
        """The function, its time added to the part; what is timed inside it counts there."""

        def timed(*arguments: Any, **named: Any) -> Any:
            self._inner.append(0)
            begun = thread_time_ns()
            answer = function(*arguments, **named)
            spent = thread_time_ns() - begun
            self._now[part] += spent - self._inner.pop()
            self._inner[-1] += spent
            return answer

        return timed
