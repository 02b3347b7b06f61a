"""Experiment 1: four goals, the same for everybody, one of them moving.

a is straight ahead, b to the right, c behind; d is a, moving with two constant velocities and then
standing still. The tool starts above the ready posture's ground point, pointing down.

Where d's velocity changes, it does so like that of anything with a mass, at `GOAL_ACCELERATION`. A
goal whose velocity jumps cannot be followed closely by any robot with limited accelerations: at the
jump of 0.45 m/s the least possible distance is 35 mm if the tool stays upright (Frankie). `jumps`
shows how near one comes to that.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from typing import Any

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from rich.table import Table

from app.lab.bench.contenders import Contender
from app.lab.bench.judge import Judge, Trial, cumulative_jerk, jerk_noise, shares
from app.lab.bench.motion import GoalAt, Motion, run_motion
from controller import READY, Array, PoseGoal, RobotModel

POSES = ("a", "b", "c", "d")
PAPER_TIMES = {"a": 5.42, "b": 6.17, "c": 6.17, "d": 13.12}
"""Time to arrive in the paper [s]."""

_PLACES = {"a": (4.0, 0.0, 0.0), "b": (0.0, -4.0, -90.0), "c": (-4.0, 0.0, 180.0)}
"""x, y [m] from where the tool starts, and heading [degrees]."""
_LOWER = 0.25
"""Goals are this far below the height at which the tool starts [m]."""
_LEGS = ((6.0, (0.2, 0.2)), (12.0, (0.0, -0.2)))
"""Until when [s] the goal of d moves how fast [m/s]."""
GOAL_ACCELERATION = 1.0
"""How fast the velocity of the goal of d changes [m/s^2]."""
_SETTLED = 5.0
"""From here on the error of d counts [s]."""
_LIMIT, _LIMIT_D = 20.0, 16.0

_COLUMNS = (
    "arrived s",
    "paper s",
    "error mm",
    "error °",
    "jerk",
    "÷ example",
    "m min",
    "m mean",
    "speed %",
    "accel. %",
    "over limit",
    "contact",
)
_CAPTION = (
    "Errors of d: the worst from 5 s on. Jerk: cumulative, of the tool, from rest (m/s²), and"
    " divided by that of the published example. Speed, accel.: most of a limit that was used."
)


def goal_of(
    pose: str,
    model: RobotModel,
    tolerances: tuple[float, float],
    *,
    twist_known: bool = True,
    acceleration: float = GOAL_ACCELERATION,
) -> GoalAt:
    """Where the goal of a pose is at any time.

    Args:
        pose: a, b, c or d.
        model: the robot.
        tolerances: of position [m] and orientation [rad].
        twist_known: whether the goal comes with its velocity.
        acceleration: of a goal that moves; infinite lets its velocity jump [m/s^2].
    """
    start = model.bTe(READY).translation
    x, y, heading = _PLACES["a" if pose == "d" else pose]
    R = pin.rpy.rpyToMatrix(np.pi, 0.0, np.deg2rad(heading))
    speed = float(model.limits.base_twist[0])
    at_first = start + np.array([x, y, -_LOWER])

    def goal_at(time: float) -> PoseGoal:
        place, twist = at_first.copy(), np.zeros(6)
        if pose == "d":
            moved, velocity = _moved(time, acceleration)
            place[:2] += moved
            if twist_known:
                twist[:2] = velocity
        return PoseGoal(
            wTe=SE3(R, place),
            twist=twist,
            speed=speed,
            position_tolerance=tolerances[0],
            orientation_tolerance=tolerances[1],
        )

    return goal_at


def _moved(time: float, acceleration: float) -> tuple[Array, Array]:
    """How far the goal of d has moved [m], and how fast it moves [m/s]; both (2,)."""
    moved, velocity, begun = np.zeros(2), np.zeros(2), 0.0
    for until, wanted in (*_LEGS, (np.inf, (0.0, 0.0))):
        change = np.array(wanted) - velocity
        changing = float(np.linalg.norm(change)) / acceleration
        spent = min(time, until) - begun
        part = min(spent / changing, 1.0) if changing > 0.0 else 1.0
        moved += velocity * spent + change * (spent - 0.5 * part * changing) * part
        velocity = velocity + part * change
        begun = until
        if time < until:
            break
    return moved, velocity


@dataclass(frozen=True, kw_only=True, eq=False)
class PoseRun:
    """One pose, driven to by one contender."""

    pose: str
    contender: Contender
    goal_at: GoalAt
    motion: Motion
    trial: Trial
    manipulability: Array
    """(k + 1,) of the arm over time."""
    velocity_share: Array
    """(k, n) of the limits."""


@dataclass(frozen=True, kw_only=True)
class PoseResult:
    """The figures of one run."""

    robot: str
    preset: str
    base_speed: float
    pose: str
    period_s: float
    time_s: float | None
    """To arrive; for d, from when on the goal stands still. None if it never did."""
    paper_time_s: float
    position_error_mm: float
    """At the end; for d the worst from 5 s on."""
    orientation_error_deg: float
    """At the end; for d the worst from 5 s on."""
    jerk: float
    """Cumulative, of the tool, from rest [m/s^2]."""
    jerk_noise: float
    """What rounding contributes to it [m/s^2]."""
    manipulability_min: float
    manipulability_mean: float
    velocity_share_max: float
    """Of the limits."""
    acceleration_share_max: float
    """Of the limits."""
    limit_violations: int
    contact_samples: int


def run_pose(
    contender: Contender, pose: str, tolerances: tuple[float, float], *, jumps: bool = False
) -> PoseRun:
    """Drive to a pose; d goes on after it has arrived.

    Args:
        contender: who drives.
        pose: a, b, c or d.
        tolerances: of position [m] and orientation [rad].
        jumps: the velocity of the goal of d jumps.
    """
    model = contender.model()
    judge = Judge(model)
    # The published controller has no use for the goal's velocity.
    goal_at = goal_of(
        pose,
        model,
        tolerances,
        twist_known=contender.preset == "frankie",
        acceleration=np.inf if jumps else GOAL_ACCELERATION,
    )
    moving = pose == "d"
    motion = run_motion(
        contender.stepper(model),
        model,
        goal_at,
        period=contender.period,
        limit=_LIMIT_D if moving else _LIMIT,
        stop_on_arrival=not moving,
    )
    return PoseRun(
        pose=pose,
        contender=contender,
        goal_at=goal_at,
        motion=motion,
        trial=judge(motion),
        manipulability=np.array([judge.manipulability(q) for q in motion.q]),
        velocity_share=shares(model, motion)[0],
    )


def result_of(run: PoseRun) -> PoseResult:
    """The figures of a run."""
    motion, times, goal = run.motion, run.motion.times(), run.goal_at(0.0)
    within = (motion.position_error <= goal.position_tolerance) & (
        motion.orientation_error <= goal.orientation_tolerance
    )
    counts = slice(-1, None)
    if run.pose == "d":
        within &= times >= _LEGS[-1][0]
        counts = slice(round(_SETTLED / motion.period), None)
    model = run.contender.model()
    return PoseResult(
        robot=run.contender.robot,
        preset=run.contender.preset,
        base_speed=float(model.limits.base_twist[0]),
        pose=run.pose,
        period_s=motion.period,
        time_s=float(times[np.argmax(within)]) if within.any() else None,
        paper_time_s=PAPER_TIMES[run.pose],
        position_error_mm=1e3 * float(motion.position_error[counts].max()),
        orientation_error_deg=float(np.rad2deg(motion.orientation_error[counts].max())),
        jerk=cumulative_jerk(motion.tool, motion.period),
        jerk_noise=jerk_noise(motion.tool, motion.period),
        manipulability_min=float(run.manipulability.min()),
        manipulability_mean=float(run.manipulability.mean()),
        velocity_share_max=float(run.velocity_share.max()),
        acceleration_share_max=float(shares(model, motion)[1].max()),
        limit_violations=run.trial.violations.samples,
        contact_samples=run.trial.touches.samples,
    )


def poses_tables(results: Sequence[PoseResult], rival: Sequence[PoseResult]) -> Iterator[Table]:
    """For people, one table for every contender.

    Args:
        results: what was asked for.
        rival: the published example on the same poses, for the ratio of the jerks.
    """
    jerks = {(row.robot, row.pose): row.jerk for row in rival}
    for (robot, preset, speed), group in groupby(
        results, key=lambda row: (row.robot, row.preset, row.base_speed)
    ):
        title = f"Experiment 1: {robot}, {preset}, base up to {speed:.1f} m/s"
        table = Table(title=title, title_justify="left", caption=_CAPTION, caption_justify="left")
        table.add_column("pose")
        for name in _COLUMNS:
            table.add_column(name, justify="right")
        for row in group:
            table.add_row(
                row.pose,
                "-" if row.time_s is None else f"{row.time_s:.2f}",
                f"{row.paper_time_s:.2f}",
                f"{row.position_error_mm:.1f}",
                f"{row.orientation_error_deg:.2f}",
                f"{row.jerk:.1f}",
                f"{row.jerk / jerks[robot, row.pose]:.2f}",
                f"{row.manipulability_min:.3f}",
                f"{row.manipulability_mean:.3f}",
                f"{100 * row.velocity_share_max:.0f}",
                f"{100 * row.acceleration_share_max:.0f}",
                str(row.limit_violations),
                str(row.contact_samples),
            )
        yield table


def poses_json(results: Sequence[PoseResult], about: dict[str, Any]) -> str:
    """One JSON object: `about` the run, and `results`, one object per robot and pose."""
    return json.dumps(about | {"results": [asdict(row) for row in results]}, indent=2)
