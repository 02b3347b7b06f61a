"""Following goals that keep moving: the error after catching up.

Every goal moves at a constant speed at constant height; the paths differ in how they turn. The tool
points down, and does not turn.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from rich.table import Table

from config.poses import MapPose
from controller import Array, PoseGoal
from lab.bench.configuration import Configuration
from lab.bench.motion_evaluation import Evaluator
from lab.bench.simulated_motion import GoalAt, run_motion
from lab.shared import fixed, run_in_order, table

PATHS = ("line", "circle 1 m", "circle 0.5 m", "sine", "random walk")
_START = np.array([1.5, -0.5, 0.7])  # position of the goals at first [m]
_SINE_HEADING, _SINE_PERIOD = np.deg2rad(60.0), 8.0  # largest heading [rad], and period [s]
_WALK_TURN, _WALK_MEMORY = 0.4, 1.0
"""Standard deviation of the turn rate of the random walk [rad/s], and its correlation time [s]."""
_SPEED = 0.3  # of the goals [m/s]
_DURATION, _CATCHING_UP = 45.0, 12.0  # of a motion, and until its errors count [s]


@dataclass(frozen=True, kw_only=True)
class Following:
    """A goal to follow."""

    path: str
    known: bool  # whether the controller is given the velocity of the goal


@dataclass(frozen=True, kw_only=True)
class Followed:
    """Errors after catching up, and counts from the start."""

    robot: str
    base_speed: float
    path: str
    known: bool
    error_max_mm: float
    limit_violations: int
    contact_samples: int


def moving_goal(following: Following, period: float) -> GoalAt:
    """The goal as a function of time, at multiples of the control period [s]."""
    times = np.asarray(np.arange(round(_DURATION / period) + 1) * period, float)
    turn = _turn_rates(following, times, period)
    heading = np.concatenate([[0.0], np.cumsum(turn[:-1] * period)])
    if following.path == "sine":
        heading -= heading.mean()
    middle = heading + 0.5 * turn * period
    steps = _SPEED * period * np.stack([np.cos(middle), np.sin(middle)], axis=1)
    places = np.vstack([np.zeros(2), np.cumsum(steps[:-1], axis=0)])

    def goal_at(time: float) -> PoseGoal[MapPose]:
        k = round(time / period)
        c, s = np.cos(heading[k]), np.sin(heading[k])
        twist = np.array([_SPEED * c, _SPEED * s, 0.0, 0.0, 0.0, 0.0])
        mTe = SE3(pin.rpy.rpyToMatrix(np.pi, 0.0, 0.0), _START + np.array([*places[k], 0.0]))
        return PoseGoal(target=mTe, twist=twist if following.known else None)

    return goal_at


def _turn_rates(following: Following, times: Array, period: float) -> Array:
    """Turn rate of the direction of motion at every time [rad/s]."""
    match following.path:
        case "line":
            return np.zeros(len(times))
        case "sine":
            phase = 2.0 * np.pi * times / _SINE_PERIOD
            turn = _SINE_HEADING * 2.0 * np.pi / _SINE_PERIOD * np.cos(phase)
            return np.asarray(turn, float)
        case "random walk":
            kernel = np.exp(-0.5 * (np.arange(-3.0, 3.0, period / _WALK_MEMORY)) ** 2)
            noise = np.random.default_rng(0).normal(size=len(times) + len(kernel) - 1)
            walk = np.convolve(noise, _WALK_TURN * kernel / np.linalg.norm(kernel), "valid")
            return np.asarray(walk, float)
        case circle:
            radius = float(circle.split()[1])
            return np.asarray(np.full(len(times), _SPEED / radius), float)


def run_following(
    configuration: Configuration, followings: Sequence[Following], workers: int | str | None = 1
) -> list[Followed]:
    """Follow each of several goals from rest."""
    tasks = [(configuration, following) for following in followings]
    return run_in_order(_follow, tasks, workers=workers)


def _follow(task: tuple[Configuration, Following]) -> Followed:
    configuration, following = task
    model, period = configuration.model(), configuration.period
    motion = run_motion(
        configuration.step(model),
        model,
        moving_goal(following, period),
        period=period,
        limit=_DURATION,
        stop_on_arrival=False,
    )
    first = round(_CATCHING_UP / period)
    trial = Evaluator(model)(motion)
    return Followed(
        robot=configuration.robot,
        base_speed=float(model.limits.base_twist[0]),
        path=following.path,
        known=following.known,
        error_max_mm=1e3 * float(motion.position_error[first:].max()),
        limit_violations=trial.limit_violations,
        contact_samples=trial.contact_samples,
    )


def moving_table(rows: Sequence[Followed]) -> Table:
    """One row for every goal."""
    return table(
        "Goals that keep moving",
        rows,
        {
            "robot": lambda row: row.robot,
            "base m/s": lambda row: f"{row.base_speed:.1f}",
            "path": lambda row: row.path,
            "velocity": lambda row: "given" if row.known else "estimated",
        },
        {
            "max mm": lambda row: fixed(row.error_max_mm, 1),
            "over limit": lambda row: row.limit_violations,
            "contact": lambda row: row.contact_samples,
        },
        title_justify="left",
    )
