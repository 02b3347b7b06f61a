"""Snapshot of a run after one tick, and the scene that it is drawn in."""

from dataclasses import dataclass
from math import degrees, hypot, isfinite, sqrt
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from app.live.nodes import NodeInfo, NodeStatus
from behaviours import Region
from config.arrays import Array
from config.planar import Pose2D
from config.poses import MapFromOdometry, MapPose
from controller import BaseGoal, Command, MotionGoal, PointCloud, PoseGoal, StepReport
from hw import DepthFrame, LaserScan, RobotState
from perception import Detection, GraspEstimate
from perception.registration import Registration
from robots import Geom, RobotDescription

_HERE: MapFromOdometry = SE3.Identity()


class PoseEstimate(NamedTuple):
    """Where the robot believes to be on the map, where that is an estimate."""

    mTb: Array
    """(3,) the newest: x, y [m], heading [rad]; what is drawn and done follows it smoothly."""
    covariance: Array  # (3, 3) of it
    mTo: MapFromOdometry  # odometry on the map, as it is drawn
    registration: Registration | None = None  # the newest; the same object until there is another
    scan: LaserScan | None = None  # the newest of the laser that was registered; as above
    true_base: SE3 | None = None  # where the base is in simulation

    @property
    def two_sigma(self) -> tuple[float, float]:
        """Two standard deviations of the position in its worst direction [m], and heading [rad]."""
        (a, b, _), (_, d, _), (_, _, heading) = self.covariance.tolist()
        largest = (a + d) / 2.0 + hypot((a - d) / 2.0, b)  # eigenvalue of the position's
        return 2.0 * sqrt(largest), 2.0 * sqrt(heading)


@dataclass(kw_only=True, eq=False, slots=True)
class Snapshot:
    """What viewers, recording and log get of one tick.

    The loop makes one in every tick, so it only refers to existing objects. Treat it as frozen;
    a frozen dataclass would take twice as long to make.
    """

    tick: int
    time: float  # of the task, from its first tick, without pauses [s]
    paused_s: float = 0.0  # total duration of the pauses so far [s]
    state: RobotState
    command: Command
    report: StepReport
    seconds: float  # computing time of the tick [s]
    nodes: tuple[NodeStatus, ...]
    changed: bool = False  # whether the status of a node changed in this tick
    phases: frozenset[str] = frozenset()  # of the leaves that run, as `grasp` and `descend`
    paused: str = ""  # why the run is paused; empty if it is not
    too_slow: str = ""  # that the computer does not keep real time; empty if it does
    attempts: int = 0  # at grasps so far
    placed: int = 0  # number of objects so far
    holds: bool = False  # whether the hand carries an object
    goal: MotionGoal[MapPose] | None
    estimate: PoseEstimate | None = None  # None where the localisation is exact
    objects: tuple[SE3, ...] = ()
    """Poses in the world of the simulated objects, in the order of `SceneView.objects`."""
    frame: DepthFrame | None = None  # the depth image that arrived in this tick, at its own stamp
    pictures: tuple[tuple[str, DepthFrame], ...] = ()  # that the task keeps, by name
    detection: Detection | None = None
    grasp: GraspEstimate | None = None
    locked: bool = False
    seen: PointCloud | None = None  # depth obstacles; the same object until they change

    @property
    def stamp(self) -> float:
        """On the session's clock [s]."""
        return self.state.stamp

    @property
    def mTo(self) -> MapFromOdometry:
        """Odometry on the map, as it is drawn."""
        return _HERE if self.estimate is None else self.estimate.mTo

    @property
    def mTb(self) -> MapPose:
        """Base on the map."""
        return self.mTo * self.state.oTb

    @property
    def mTe(self) -> MapPose:
        """End effector on the map."""
        mTe: MapPose = self.mTb * self.report.bTe
        return mTe

    @property
    def hand_goal(self) -> MapPose | None:
        """Goal pose of the end effector on the map, if there is one."""
        return self.goal.target if isinstance(self.goal, PoseGoal) else None

    @property
    def base_goal(self) -> Pose2D | None:
        """Goal pose of the base on the map, if it is chosen."""
        goal = self.goal
        return Pose2D.of(goal.target) if isinstance(goal, BaseGoal) else self.report.stance

    @property
    def way(self) -> Array | None:
        """(N, 3) path of the base: x, y [m], heading [rad]; the same object until it changes."""
        return None if self.base_goal is None else self.report.way


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneView:
    """Shapes of the scene, empty if unknown, and what the task names in it."""

    fixtures: tuple[Geom, ...] = ()
    objects: tuple[tuple[str, tuple[Geom, ...]], ...] = ()  # names, and shapes in their own frames
    regions: tuple[Region, ...] = ()
    goals: tuple[tuple[str, SE3], ...] = ()
    estimated: bool = False  # whether snapshots have a `PoseEstimate`


class ShownRun(NamedTuple):
    """What snapshots of a run do not say, as they all would say the same."""

    robot: RobotDescription
    tree: tuple[NodeInfo, ...]  # in preorder
    scene: SceneView
    began: int  # time zero of the session's clock [ns since 1970]


def key_figures(snapshot: Snapshot) -> dict[str, float]:
    """Figures that help to explain a failure, by name with unit; finite ones only."""
    report, state = snapshot.report, snapshot.state
    x, y = snapshot.mTb.translation[:2]
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
