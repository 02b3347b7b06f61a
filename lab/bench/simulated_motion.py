"""Simulation of one motion with a controller: exact integration, or with first-order lag."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, exp, sin
from typing import TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.planar import in_space
from config.poses import MapPose
from controller import (
    OPEN_FLOOR,
    Array,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    RobotModel,
    StepReport,
    Surroundings,
)

GoalAt: TypeAlias = Callable[[float], PoseGoal[MapPose]]  # the goal at a time since the start [s]
SurroundingsAt: TypeAlias = Callable[[float], Surroundings]  # at a time since the start [s]
Step: TypeAlias = Callable[
    [KinematicState, MotionGoal[MapPose] | None, Command, Surroundings], tuple[Command, StepReport]
]
"""The step of a controller: state, goal, last command and obstacles to the next command."""

_PROGRESS = 1e-3  # an error that decreases by less than this is no progress [m]
_METRES_PER_RADIAN = 0.3  # weight of the orientation error in the measure of progress


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """One motion, sampled at every one of its k periods."""

    period: float  # control period [s]
    base: Array  # (k + 1, 3) x, y [m] and heading [rad] of the base
    q: Array  # (k + 1, j) joint positions [rad]
    velocities: Array  # (k, n) of all degrees of freedom, base first
    tool: Array  # (k + 1, 3) position of the end effector in the world [m]
    position_error: Array  # (k + 1,) distance to the goal of that time [m]
    orientation_error: Array  # (k + 1,) angle to the goal of that time [rad]
    solved: bool  # whether the QP had a solution in every period
    arrived: bool  # whether the motion ended because the goal was reached
    unreachable: str = ""  # why the controller reported the goal as unreachable; else empty

    @property
    def duration(self) -> float:
        """By the clock of the controller [s]."""
        return len(self.velocities) * self.period

    def times(self) -> Array:
        """(k + 1,) times of the samples [s]."""
        return np.asarray(np.arange(len(self.base)) * self.period)


def pose_errors(mTe: MapPose, goal: SE3) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses."""
    distance = float(np.linalg.norm(goal.translation - mTe.translation))
    return distance, float(np.linalg.norm(pin.log3(mTe.rotation.T @ goal.rotation)))


def run_motion(
    step: Step,
    model: RobotModel,
    goal_at: GoalAt,
    *,
    period: float,
    limit: float,
    patience: float = np.inf,
    stop_on_arrival: bool = True,
    start: Array | None = None,
    elapsed: Callable[[], float] | None = None,
    surroundings_at: SurroundingsAt = lambda time: OPEN_FLOOR,
    lag: bool = False,
) -> Motion:
    """Move from rest at the origin until the goal is reached or time is up.

    `step` computes the commands from the `goal_at` a time, with the obstacles of `surroundings_at`;
    a goal that it reports as unreachable ends the motion. `period` is that of control, `limit` the
    longest time and `patience` that without progress [s]; `start` are (j,) joint positions [rad],
    None for ready. `elapsed` draws the true duration of a period [s], unknown to the controller;
    with `lag`, base and arm follow with the lags of the robot's description.
    """
    q = model.description.arm.ready.copy() if start is None else start
    state = KinematicState(mTb=SE3.Identity(), q=q)
    heading = 0.0
    last = applied = Command.stop(len(q))
    bases = [np.array([*state.mTb.translation[:2], heading])]
    postures, tools, errors = [state.q], [], []
    velocities: list[Array] = []
    solved, arrived, unreachable = True, False, ""
    best, best_at = np.inf, 0.0
    for index in range(round(limit / period) + 1):
        time = index * period
        goal = goal_at(time)
        mTe = model.end_effector(state.mTb, state.q)
        error = pose_errors(mTe, goal.target)
        tools.append(mTe.translation.copy())
        errors.append(error)
        arrived = error[0] <= goal.position_tolerance and error[1] <= goal.orientation_tolerance
        far = error[0] + _METRES_PER_RADIAN * error[1]
        if far < best - _PROGRESS:
            best, best_at = far, time
        if (arrived and stop_on_arrival) or time - best_at > patience or time >= limit:
            break
        if unreachable:
            break
        last, report = step(state, goal, last, surroundings_at(time))
        solved, unreachable = solved and report.solved, report.unreachable
        duration = period if elapsed is None else elapsed()
        applied = _lagged(model, applied, last, duration) if lag else last
        heading = heading + applied.base_twist[2] * duration
        state = KinematicState(
            mTb=integrate_base(state.mTb, heading, applied, duration),
            q=state.q + applied.qd * duration,
        )
        velocities.append(model.velocities(last))
        bases.append(np.array([*state.mTb.translation[:2], heading]))
        postures.append(state.q)
    return Motion(
        period=period,
        base=np.array(bases),
        q=np.array(postures),
        velocities=np.array(velocities).reshape(-1, model.n),
        tool=np.array(tools),
        position_error=np.array([error[0] for error in errors]),
        orientation_error=np.array([error[1] for error in errors]),
        solved=solved,
        arrived=arrived,
        unreachable=unreachable,
    )


def _lagged(model: RobotModel, before: Command, command: Command, period: float) -> Command:
    """The velocities that a robot with first-order lag has a period later."""
    base = 1.0 - exp(-period / model.description.base.lag)
    arm = 1.0 - exp(-period / model.description.arm.lag)
    return Command(
        base_twist=before.base_twist + base * (command.base_twist - before.base_twist),
        qd=before.qd + arm * (command.qd - before.qd),
    )


def integrate_base(mTb: MapPose, heading: float, command: Command, period: float) -> SE3:
    """Base pose after a period on an exact arc that ends at this heading [rad]."""
    vx, vy, turn = command.base_twist * period
    forward, sideways = 1.0, 0.0
    if abs(turn) > 1e-9:
        forward, sideways = sin(turn) / turn, (1.0 - cos(turn)) / turn
    step = np.array([forward * vx - sideways * vy, sideways * vx + forward * vy, 0.0])
    return SE3(in_space((0.0, 0.0, heading)).rotation, mTb.translation + mTb.rotation @ step)
