"""What a step costs where much is near: the same steps among furniture and without."""

from __future__ import annotations

import gc
from dataclasses import dataclass, field
from time import perf_counter_ns, thread_time_ns

import numpy as np

from controller import (
    OPEN_FLOOR,
    Command,
    HolisticController,
    KinematicState,
    MotionGoal,
    PoseGoal,
    StepReport,
    Surroundings,
)
from lab.bench.motion import Controller, run_motion
from lab.bench.obstacles import Setup, make_world
from lab.bench.step import Timing

ROWS = (15, 25)
"""Fewest and most pairs of shapes that are near each other in the steps that are counted."""
_FAMILIES = ("table", "shelf")
_WORLDS = 8
"""Of each family, at most."""
_LIMIT = 10.0
"""Of one motion [s]."""


@dataclass(kw_only=True, eq=False)
class _Twins:
    """Two controllers with one state and goal; only the first knows what stands around, and moves.

    Who is asked first is drawn for every step.
    """

    knows: Controller
    blind: Controller
    rng: np.random.Generator
    times: list[tuple[tuple[int, int], tuple[int, int]]] = field(default_factory=list)
    """Wall and processor time of every step of both, where enough was near [ns]."""

    def step(
        self,
        state: KinematicState,
        goal: MotionGoal | None,
        last: Command,
        surroundings: Surroundings = OPEN_FLOOR,
    ) -> tuple[Command, StepReport]:
        """The step of the first."""
        twins = ((self.knows, surroundings), (self.blind, OPEN_FLOOR))
        results, times = {}, {}
        for one in self.rng.permutation(2).tolist():
            controller, around = twins[one]
            wall, cpu = perf_counter_ns(), thread_time_ns()
            results[one] = controller.step(state, goal, last, around)
            cpu, wall = thread_time_ns() - cpu, perf_counter_ns() - wall
            times[one] = wall, cpu
        if ROWS[0] <= results[0][1].near_pairs <= ROWS[1]:
            self.times.append((times[0], times[1]))
        return results[0]


def time_near(robot: str, *, steps: int, seed: int) -> list[Timing]:
    """Time steps on the way to goals on tables and in shelves, and the same on an open floor.

    Args:
        robot: frankie or omni.
        steps: how many at least, where the worlds have that many.
        seed: of the worlds, and of the order of the controllers.
    """
    setup, rng = Setup(robot=robot, seed=seed), np.random.default_rng(seed)
    configuration = setup.configuration("frankie")
    model = configuration.model()
    times: list[tuple[tuple[int, int], tuple[int, int]]] = []
    worlds = [(family, number) for number in range(_WORLDS) for family in _FAMILIES]
    gc.collect()
    gc.disable()
    try:
        for family, number in worlds:
            world = make_world(setup, family, number)
            knows = HolisticController(model)
            knows.prepare(world.surroundings(0.0))
            twins = _Twins(knows=knows, blind=HolisticController(model), rng=rng)
            goal = PoseGoal(wTe=world.goal, speed=float(model.limits.base_twist[0]))
            run_motion(
                twins,
                model,
                lambda time, goal=goal: goal,  # type: ignore[misc]
                period=setup.period,
                limit=_LIMIT,
                surroundings_at=world.surroundings,
                lag=True,
            )
            times += twins.times
            gc.collect()
            if len(times) >= steps:
                break
    finally:
        gc.enable()
    names = (f"{ROWS[0]} to {ROWS[1]} pairs near", "the same, nothing near")
    every = np.array(times, dtype=float).reshape(-1, 2, 2)
    return [Timing.of(name, *every[:, twin].T) for twin, name in enumerate(names) if len(every)]
