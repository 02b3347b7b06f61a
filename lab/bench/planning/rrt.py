"""Paths of the arm by RRT-Connect, from the Open Motion Planning Library."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from config import UserError, extra
from config.arrays import Array


class PlanningError(UserError):
    """The planning library is not installed."""


def planning_library() -> Any:
    """The modules of OMPL, with its messages off.

    Raises:
        PlanningError: it is not installed.
    """
    try:
        base, geometric, util = (
            import_module(f"ompl.{name}") for name in ("base", "geometric", "util")
        )
    except ImportError:
        raise PlanningError(f"--motion planning needs an extra: {extra('planning')}") from None
    util.noOutputHandler()
    return base, geometric, util


def rrt_connect(
    start: Array,
    goal: Array,
    limits: tuple[Array, Array],
    is_free: Callable[[Array], bool],
    *,
    seed: int,
    checks: int,
    shortcuts: int,
    resolution: float,
) -> Array | None:
    """Postures (M, j) from start to goal, shortened and smoothed [rad]; None if not found.

    The budget is a number of checks, not a time: the same seed gives the same path.

    Args:
        start: (j,) [rad].
        goal: (j,) [rad].
        limits: lower and upper joint positions, (j,) each [rad].
        is_free: whether a posture (j,) is free of contact.
        seed: of the random numbers, at least 1.
        checks: largest number of postures that are checked.
        shortcuts: number of shortcuts that are tried.
        resolution: distance between postures that are checked [rad].
    """
    base, geometric, util = planning_library()
    util.RNG.setSeed(seed)
    space = base.RealVectorStateSpace(len(start))
    bounds = base.RealVectorBounds(len(start))
    for joint, (low, high) in enumerate(zip(*limits, strict=True)):
        bounds.setLow(joint, min(float(low), float(start[joint])))
        bounds.setHigh(joint, max(float(high), float(start[joint])))
    space.setBounds(bounds)
    asked = 0

    def valid(state: Any) -> bool:
        nonlocal asked
        asked += 1
        return is_free(_posture(state, len(start)))

    information = base.SpaceInformation(space)
    information.setStateValidityChecker(valid)
    information.setStateValidityCheckingResolution(resolution / space.getMaximumExtent())
    information.setup()
    problem = base.ProblemDefinition(information)
    problem.setStartAndGoalStates(_state(space, start), _state(space, goal))
    planner = geometric.RRTConnect(information)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(base.PlannerTerminationCondition(lambda: asked >= checks))
    if not problem.hasExactSolution():
        return None
    path = problem.getSolutionPath()
    if path.getStateCount() > 2:
        simplifier = geometric.PathSimplifier(information)
        simplifier.reduceVertices(path, shortcuts)
        simplifier.partialShortcutPath(path, shortcuts, shortcuts)
        simplifier.smoothBSpline(path, 3)
    return np.array([_posture(state, len(start)) for state in path.getStates()])


def _posture(state: Any, j: int) -> Array:
    return np.array([state[joint] for joint in range(j)])


def _state(space: Any, q: Array) -> Any:
    state = space.allocState()
    for joint, value in enumerate(q.tolist()):
        state[joint] = value
    return state
