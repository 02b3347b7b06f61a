"""The state of a run after one tick, and the scene that it is drawn in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees, isfinite
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from app.live.nodes import NodeStatus
from controller import Pose2D

if TYPE_CHECKING:
    from pinocchio import SE3

    from controller import Command, MotionGoal, PointCloud, StepReport
    from hw import DepthFrame, RobotState
    from perception import Detection, GraspEstimate
    from robots import Geom

Array = npt.NDArray[np.float64]


@dataclass(kw_only=True, eq=False, slots=True)
class Snapshot:
    """Everything that viewers, recording and log learn about one tick.

    The loop makes one in every tick, so it only keeps what is there already; what follows from that
    is worked out by who wants to know it. Nobody changes one; it is not frozen, because that takes
    twice as long to make.
    """

    tick: int
    time: float
    """Of the task, from its first tick, pauses left out: what people are told [s]."""
    paused_s: float = 0.0
    """How long it was paused so far [s]."""
    state: RobotState
    command: Command
    """As sent."""
    report: StepReport
    seconds: float
    """Computing time of the tick [s]."""
    nodes: tuple[NodeStatus, ...]
    """In preorder."""
    goal: MotionGoal | None
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
    seen: PointCloud | None = None
    """The obstacles that the camera has seen; the same object as long as they are the same."""
    blackboard: Mapping[str, object] = field(default_factory=dict)
    """The values of the task's keys."""

    @property
    def stamp(self) -> float:
        """On the session's clock [s]."""
        return self.state.stamp

    @property
    def wTe(self) -> SE3:
        """End effector in the world."""
        return self.state.wTb * self.report.bTe

    @property
    def hand_goal(self) -> SE3 | None:
        """Desired end-effector pose in the world, if there is one."""
        return getattr(self.goal, "wTe", None)

    @property
    def base_goal(self) -> Pose2D | None:
        """Where the base is to stand, in the world, if that is chosen."""
        wTb = getattr(self.goal, "wTb", None)
        return self.report.stance if wTb is None else Pose2D.of(wTb)

    @property
    def way(self) -> Array | None:
        """(N, 3) poses x, y, heading of the base on its way there [m, rad].

        The same object as long as the way is the same.
        """
        return None if self.base_goal is None else self.report.way


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
    report, state = snapshot.report, snapshot.state
    x, y = state.wTb.translation[:2]
    figures = {
        "goal distance [m]": report.position_error,
        "goal angle [deg]": degrees(report.orientation_error),
        "fingers apart [mm]": 1000.0 * state.gripper_width,
        "base x [m]": float(x),
        "base y [m]": float(y),
        "base speed [m/s]": float(np.hypot(*state.base_twist[:2])),
        "fastest joint [rad/s]": float(np.abs(state.qd).max()),
        "manipulability": report.manipulability,
        "grasp quality": snapshot.grasp.quality if snapshot.grasp is not None else float("nan"),
    }
    return {name: round(value, 4) for name, value in figures.items() if isfinite(value)}
