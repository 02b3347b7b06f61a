"""Where the time of a step goes: the functions that a step is made of, timed while it runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter_ns
from typing import Any

import numpy as np

import controller.controller
import controller.holistic
from app.bench.motion import Stepper
from controller import Body, Command, KinematicState, MotionGoal, RobotModel, StepReport
from controller.guidance import Guide
from controller.programme import Solver

PARTS: dict[str, tuple[tuple[Any, str], ...]] = {
    "checks and bounds": (
        (controller.controller, "require_sound"),
        (controller.controller, "velocity_bounds"),
    ),
    "kinematics": ((RobotModel, "kinematics"),),
    "manipulability": ((controller.holistic, "manipulability"),),
    "guidance": ((Guide, "pull"),),
    "contact": ((Body, "near"),),
    "assemble": ((controller.controller, "assemble"),),
    "solve": ((Solver, "solve"),),
}
"""The functions of every part, by where they are looked up."""


class PartTimer:
    """Answers like a controller and notes how long the parts of its steps take.

    Args:
        stepper: the controller.
    """

    def __init__(self, stepper: Stepper) -> None:
        self._stepper = stepper
        self._now: dict[str, int] = {}
        self._inner = [0]
        self._steps: list[dict[str, int]] = []

    def step(
        self, state: KinematicState, goal: MotionGoal | None, last: Command
    ) -> tuple[Command, StepReport]:
        """The command for the next period."""
        self._now = dict.fromkeys(PARTS, 0)
        begun = perf_counter_ns()
        answer = self._stepper.step(state, goal, last)
        total = perf_counter_ns() - begun
        self._steps.append(self._now | {"rest": total - sum(self._now.values())})
        return answer

    def medians(self) -> dict[str, float]:
        """Median time of every part [µs]."""
        names = (*PARTS, "rest")
        return {name: float(np.median([s[name] for s in self._steps]) / 1e3) for name in names}

    @contextmanager
    def watching(self) -> Iterator[None]:
        """The parts are timed as long as this lasts."""
        before = [(owner, name, getattr(owner, name)) for owner, name in _functions()]
        for part, functions in PARTS.items():
            for owner, name in functions:
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
            begun = perf_counter_ns()
            answer = function(*arguments, **named)
            spent = perf_counter_ns() - begun
            self._now[part] += spent - self._inner.pop()
            self._inner[-1] += spent
            return answer

        return timed


def _functions() -> Iterator[tuple[Any, str]]:
    for functions in PARTS.values():
        yield from functions
