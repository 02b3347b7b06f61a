"""Experiment 1 of the paper: four goals, one of them moving.

a is straight ahead, b to the right, c behind; d is a, moving with two constant velocities and then
standing still. The tool starts above the ready posture's ground point, pointing down.

The velocity of d changes with `GOAL_ACCELERATION`, as that of a real object does. No robot with
limited accelerations can follow a goal whose velocity jumps without error.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from rich.table import Table

from config.poses import MapPose
from controller import Array, PoseGoal, RobotModel
from lab.bench.configuration import Configuration
from lab.bench.motion_evaluation import Evaluator, cumulative_jerk
from lab.bench.simulated_motion import GoalAt, run_motion
from lab.shared import fixed, table

POSES = ("a", "b", "c", "d")
PAPER_TIMES = {"a": 5.42, "b": 6.17, "c": 6.17, "d": 13.12}  # time to arrive in the paper [s]

_PLACES = {"a": (4.0, 0.0, 0.0), "b": (0.0, -4.0, -90.0), "c": (-4.0, 0.0, 180.0)}
"""x, y [m] from where the tool starts, and heading [degrees]."""
_LOWER = 0.25  # goals are this far below the height at which the tool starts [m]
_LEGS = ((6.0, (0.2, 0.2)), (12.0, (0.0, -0.2)))
"""End [s] and velocity [m/s] of each part of the motion of d."""
GOAL_ACCELERATION = 1.0  # of the goal of d where its velocity changes [m/s^2]
_SETTLED = 5.0  # the error of d counts from this time on [s]
_START = 0.5  # duration of the start from rest [s]
_LIMIT, _LIMIT_D = 20.0, 16.0

_CAPTION = (
    "Errors of d: the largest from 5 s on. Jerk: cumulative, of the tool, from rest (m/s²), and"
    " divided by that of the published example; later: after the first 0.5 s."
)


@dataclass(frozen=True, kw_only=True)
class PoseResult:
    """The figures of one motion."""

    robot: str
    preset: str
    base_speed: float
    reverse_speed: float
    pose: str
    period_s: float
    time_s: float | None  # to arrive; for d, after the goal has stopped. None if it did not arrive.
    paper_time_s: float
    position_error_mm: float  # at the end; for d the largest from 5 s on
    orientation_error_deg: float  # at the end; for d the largest from 5 s on
    jerk: float  # Cumulative, of the tool, from rest [m/s^2]
    later_jerk: float  # the part of it after the first 0.5 s [m/s^2]
    manipulability_min: float
    manipulability_mean: float
    limit_violations: int
    contact_samples: int


def goal_of(pose: str, model: RobotModel, tolerances: tuple[float, float]) -> GoalAt:
    """The goal of a pose at any time.

    `tolerances` are of position [m] and orientation [rad].
    """
    start = model.bTe(model.description.arm.ready).translation
    x, y, heading = _PLACES["a" if pose == "d" else pose]
    R = pin.rpy.rpyToMatrix(np.pi, 0.0, np.deg2rad(heading))
    speed = float(model.limits.base_twist[0])
    at_first = start + np.array([x, y, -_LOWER])

    def goal_at(time: float) -> PoseGoal[MapPose]:
        place = at_first.copy()
        if pose == "d":
            place[:2] += _moved(time)
        return PoseGoal(
            target=SE3(R, place),
            speed=speed,
            position_tolerance=tolerances[0],
            orientation_tolerance=tolerances[1],
        )

    return goal_at


def _moved(time: float) -> Array:
    """(2,) displacement of the goal of d [m]."""
    moved, velocity, begun = np.zeros(2), np.zeros(2), 0.0
    for until, wanted in (*_LEGS, (np.inf, (0.0, 0.0))):
        change = np.array(wanted) - velocity
        changing = float(np.linalg.norm(change)) / GOAL_ACCELERATION
        spent = min(time, until) - begun
        part = min(spent / changing, 1.0) if changing > 0.0 else 1.0
        moved += velocity * spent + change * (spent - 0.5 * part * changing) * part
        velocity = velocity + part * change
        begun = until
        if time < until:
            break
    return moved


def run_pose(
    configuration: Configuration, pose: str, tolerances: tuple[float, float]
) -> PoseResult:
    """Move to a pose; d continues after the arrival.

    `tolerances` are of position [m] and orientation [rad].
    """
    model = configuration.model()
    evaluator = Evaluator(model)
    moving = pose == "d"
    motion = run_motion(
        configuration.step(model),
        model,
        goal_of(pose, model, tolerances),
        period=configuration.period,
        limit=_LIMIT_D if moving else _LIMIT,
        stop_on_arrival=not moving,
    )
    trial, times = evaluator(motion), motion.times()
    within = (motion.position_error <= tolerances[0]) & (motion.orientation_error <= tolerances[1])
    counts = slice(-1, None)
    if moving:
        within &= times >= _LEGS[-1][0]
        counts = slice(round(_SETTLED / motion.period), None)
    manipulability = np.array([evaluator.manipulability(q) for q in motion.q])
    return PoseResult(
        robot=configuration.robot,
        preset=configuration.preset,
        base_speed=float(model.limits.base_twist[0]),
        reverse_speed=float(model.limits.base_reverse),
        pose=pose,
        period_s=motion.period,
        time_s=float(times[np.argmax(within)]) if within.any() else None,
        paper_time_s=PAPER_TIMES[pose],
        position_error_mm=1e3 * float(motion.position_error[counts].max()),
        orientation_error_deg=float(np.rad2deg(motion.orientation_error[counts].max())),
        jerk=trial.jerk,
        later_jerk=cumulative_jerk(motion.tool, motion.period, after=_START),
        manipulability_min=float(manipulability.min()),
        manipulability_mean=float(manipulability.mean()),
        limit_violations=trial.limit_violations,
        contact_samples=trial.contact_samples,
    )


def poses_tables(results: Sequence[PoseResult], example: Sequence[PoseResult]) -> Iterator[Table]:
    """One table for every configuration."""
    jerks = {(row.robot, row.pose): row.jerk for row in example}
    for (robot, preset, speed, back), group in groupby(
        results, key=lambda row: (row.robot, row.preset, row.base_speed, row.reverse_speed)
    ):
        yield table(
            f"Experiment 1: {robot}, {preset}, base at most {speed:.1f} m/s, {back:.2f} m/s back",
            group,
            {"pose": lambda row: row.pose},
            {
                "arrived s": lambda row: fixed(row.time_s, 2),
                "paper s": lambda row: fixed(row.paper_time_s, 2),
                "error mm": lambda row: fixed(row.position_error_mm, 1),
                "error °": lambda row: fixed(row.orientation_error_deg, 2),
                "jerk": lambda row: fixed(row.jerk, 1),
                "÷ example": lambda row: fixed(row.jerk / jerks[row.robot, row.pose], 2),
                "later": lambda row: fixed(row.later_jerk, 1),
                "m min": lambda row: fixed(row.manipulability_min, 3),
                "m mean": lambda row: fixed(row.manipulability_mean, 3),
                "over limit": lambda row: row.limit_violations,
                "contact": lambda row: row.contact_samples,
            },
            title_justify="left",
            caption=_CAPTION,
            caption_justify="left",
        )
