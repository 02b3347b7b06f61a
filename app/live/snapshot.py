"""The state of a run after one tick, and the scene that it is drawn in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees, isfinite
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from app.live.nodes import NodeStatus

if TYPE_CHECKING:
    from pinocchio import SE3

    from controller import Command, PointCloud, Pose2D
    from hw import DepthFrame, RobotState
    from perception import Detection, GraspEstimate
    from robots import Geom

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Signals:
    """Scalars of controller and loop in one tick; NaN where a value does not exist."""

    manipulability: float
    """Yoshikawa's measure of the arm."""
    slack: float
    """Norm of the QP's slack: the part of the goal's twist that is given up [m/s, rad/s]."""
    position_error: float
    """End effector to goal [m]."""
    orientation_error: float
    """End effector to goal [rad]."""
    heading_error: float
    """Base's heading to the goal's bearing [rad]."""
    tick_ms: float
    """Computing time of the tick [ms]."""
    clearance: float = float("nan")
    """Robot to what is nearest to it, if anything is near [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Snapshot:
    """Everything that viewers, recording and log learn about one tick."""

    tick: int
    stamp: float
    """On the session's clock [s]."""
    state: RobotState
    command: Command
    """As sent."""
    nodes: tuple[NodeStatus, ...]
    """In preorder."""
    goal: SE3 | None
    """Desired end-effector pose in the world, if there is one."""
    wTe: SE3
    """End effector in the world."""
    signals: Signals
    objects: tuple[SE3, ...] = ()
    """Poses in the world of the simulated objects, in the order of `SceneView.objects`."""
    frame: DepthFrame | None = None
    """The depth image that arrived in this tick; captured at its own stamp, then or earlier."""
    detection: Detection | None = None
    """What was detected in that image."""
    grasp: GraspEstimate | None = None
    """The tracked grasp."""
    locked: bool = False
    """Whether the tracked grasp is locked."""
    base_goal: Pose2D | None = None
    """Where the base is to stand, in the world, if that is chosen."""
    way: Array | None = None
    """(N, 3) poses x, y, heading of the base on its way there [m, rad]; the same object as long as
    the way is the same."""
    nearest: str = ""
    """What comes nearest to what; empty if nothing is near."""
    feels: tuple[Array, Array] | None = None
    """The two points (3,) between which `Signals.clearance` was measured, in the world."""
    seen: PointCloud | None = None
    """The obstacles that the camera has seen; the same object as long as they are the same."""
    blackboard: Mapping[str, object] = field(default_factory=dict)
    """The values of the task's keys."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectView:
    """The shape of an object."""

    name: str
    parts: tuple[Geom, ...]
    """In the object's frame."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RegionView:
    """A box that the task names."""

    name: str
    pose: SE3
    """Of its centre, in the world."""
    size: Array
    """(3,) edge lengths [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneView:
    """The shapes of the scene, empty if they are not known, and what the task names in it."""

    fixtures: tuple[Geom, ...] = ()
    """In the world."""
    objects: tuple[ObjectView, ...] = ()
    regions: tuple[RegionView, ...] = ()
    goals: tuple[tuple[str, SE3], ...] = ()
    """Names and poses, of hand or base, that the task goes to."""


def key_figures(snapshot: Snapshot) -> dict[str, float]:
    """The numbers that most often explain a failure, by name with unit; finite ones only."""
    signals, state = snapshot.signals, snapshot.state
    x, y = state.wTb.translation[:2]
    figures = {
        "goal distance [m]": signals.position_error,
        "goal angle [deg]": degrees(signals.orientation_error),
        "fingers apart [mm]": 1000.0 * state.gripper_width,
        "base x [m]": float(x),
        "base y [m]": float(y),
        "base speed [m/s]": float(np.hypot(*state.base_twist[:2])),
        "fastest joint [rad/s]": float(np.abs(state.qd).max()),
        "manipulability": signals.manipulability,
        "grasp quality": snapshot.grasp.quality if snapshot.grasp is not None else float("nan"),
    }
    return {name: round(value, 4) for name, value in figures.items() if isfinite(value)}
