"""A robot that does exactly what it is told, and everything that happened on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, sin
from typing import Protocol, TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import (
    READY,
    Array,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    RobotModel,
    StepReport,
)

GoalAt: TypeAlias = Callable[[float], PoseGoal]
"""The goal at a time since the start [s]."""

_PROGRESS = 1e-3
"""Nearer by less than this is no progress [m]."""
_METRES_PER_RADIAN = 0.3
"""How much a radian of orientation error weighs when progress is judged."""


class Stepper(Protocol):
    """Something that answers like the controller."""

    def step(
        self, state: KinematicState, goal: MotionGoal | None, last: Command
    ) -> tuple[Command, StepReport]:
        """The command for the next period."""


@dataclass(kw_only=True, eq=False)
class Place:
    """Where base and arm are; the start, unless said otherwise."""

    wTb: SE3 = field(default_factory=SE3.Identity)
    q: Array = field(default_factory=READY.copy)


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """One motion from rest, sampled at every one of its k periods."""

    period: float
    """Of control [s]."""
    base: Array
    """(k + 1, 3) x, y [m] and heading [rad] of the base."""
    q: Array
    """(k + 1, 7) joint positions [rad]."""
    velocities: Array
    """(k, n) of all degrees of freedom, base first."""
    tool: Array
    """(k + 1, 3) where the tool is in the world [m]."""
    position_error: Array
    """(k + 1,) distance to the goal of that time [m]."""
    orientation_error: Array
    """(k + 1,) angle to the goal of that time [rad]."""
    solved: bool
    """Whether the controller found an answer in every period."""
    arrived: bool
    """Whether the motion ended because the goal was reached."""

    @property
    def duration(self) -> float:
        """How long it took [s]."""
        return len(self.velocities) * self.period

    def times(self) -> Array:
        """(k + 1,) of the samples [s]."""
        return np.asarray(np.arange(len(self.base)) * self.period)


def errors(wTe: SE3, goal: SE3) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses."""
    distance = float(np.linalg.norm(goal.translation - wTe.translation))
    return distance, float(np.linalg.norm(pin.log3(wTe.rotation.T @ goal.rotation)))


def run_motion(
    stepper: Stepper,
    model: RobotModel,
    goal_at: GoalAt,
    *,
    period: float,
    limit: float,
    patience: float = np.inf,
    stop_on_arrival: bool = True,
) -> Motion:
    """Move from rest at the origin, arm ready, until the goal is reached or the time is over.

    Args:
        stepper: the controller.
        model: the robot.
        goal_at: where to go; arrived means within the goal's own tolerances.
        period: of control [s].
        limit: how long at most [s].
        patience: give up after this long without progress [s].
        stop_on_arrival: end there, or go on to the limit.
    """
    place, heading = Place(), 0.0
    last = Command.stop()
    bases, postures, tools, misses = [np.zeros(3)], [place.q], [], []
    velocities: list[Array] = []
    solved, arrived = True, False
    best, best_at = np.inf, 0.0
    for index in range(round(limit / period) + 1):
        time = index * period
        goal = goal_at(time)
        wTe = model.wTe(place.wTb, place.q)
        miss = errors(wTe, goal.wTe)
        tools.append(wTe.translation.copy())
        misses.append(miss)
        arrived = miss[0] <= goal.position_tolerance and miss[1] <= goal.orientation_tolerance
        far = miss[0] + _METRES_PER_RADIAN * miss[1]
        if far < best - _PROGRESS:
            best, best_at = far, time
        if (arrived and stop_on_arrival) or time - best_at > patience or time >= limit:
            break
        last, report = stepper.step(place, goal, last)
        solved = solved and report.solved
        heading = heading + last.base_twist[2] * period
        place = Place(wTb=driven(place.wTb, heading, last, period), q=place.q + last.qd * period)
        velocities.append(model.velocities(last))
        bases.append(np.array([*place.wTb.translation[:2], heading]))
        postures.append(place.q)
    return Motion(
        period=period,
        base=np.array(bases),
        q=np.array(postures),
        velocities=np.array(velocities).reshape(-1, model.n),
        tool=np.array(tools),
        position_error=np.array([miss[0] for miss in misses]),
        orientation_error=np.array([miss[1] for miss in misses]),
        solved=solved,
        arrived=arrived,
    )


def driven(wTb: SE3, heading: float, command: Command, period: float) -> SE3:
    """Base pose after a period in which it drove an exact arc and came to a heading [rad]."""
    vx, vy, turn = command.base_twist * period
    forward, sideways = 1.0, 0.0
    if abs(turn) > 1e-9:
        forward, sideways = sin(turn) / turn, (1.0 - cos(turn)) / turn
    step = np.array([forward * vx - sideways * vy, sideways * vx + forward * vy, 0.0])
    c, s = cos(heading), sin(heading)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return SE3(R, wTb.translation + wTb.rotation @ step)
