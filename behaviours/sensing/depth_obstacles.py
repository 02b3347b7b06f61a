"""Depth obstacles: points that the wrist camera has seen, without robot and held object."""

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Executor, Future

import numpy as np
from pinocchio import SE3

from behaviours.sensing.vision import Vision
from config.arrays import Mask
from config.poses import OdometryPose
from controller import Array, PointCloud, RobotModel
from hw import DepthFrame, InlineExecutor, RobotState
from perception import SurfaceGrid, surface_cells
from robots import Box, Geom, RobotDescription, bounding_radius, from_rounded_boxes, rounded_box

_FRAME_INTERVAL = 0.1  # the camera is asked for a frame that nobody asked for this long [s]
_MARGIN = 0.03  # points this near to the robot are the robot's own [m]
_MOST_STATES = 100  # readings that are kept, to know the posture in a frame
_HELD = (0.14, 0.10)  # assumed reach of a held object along and across the pads [m]
_HELD_ABOVE, _HELD_BELOW = 0.04, 0.03  # added to its known height [m]

NO_POINTS = PointCloud(np.zeros((0, 3)))


class DepthObstacles:
    """Keeps a point cloud of the surroundings, updated by depth frames.

    Args:
        description: of the robot.
        executor: processes the frames; None processes them in the tick.
    """

    def __init__(self, description: RobotDescription, executor: Executor | None = None) -> None:
        self._description = description
        self._model = RobotModel(description)
        self._executor = executor or InlineExecutor()
        self._surfaces = SurfaceGrid()
        self._states: deque[RobotState] = deque(maxlen=_MOST_STATES)
        self._since = -np.inf
        self._frame: DepthFrame | None = None
        self._work: Future[PointCloud] | None = None
        self.cloud = NO_POINTS
        """The present points."""

    def look(
        self, vision: Vision, state: RobotState, held: Sequence[Geom], moving: Sequence[Geom] = ()
    ) -> None:
        """Process the newest frame, if there is a new one.

        Args:
            vision: supplies the frame.
            state: of this tick.
            held: shapes of the held object, in e.
            moving: obstacles in odometry, left out as they would leave a trail.
        """
        self._states.append(state)
        self._take_result()
        if self._work is not None:
            return
        frame = vision.newest(state.stamp - _FRAME_INTERVAL)
        if frame is None or frame is self._frame or frame.stamp < self._since:
            return
        self._frame = frame
        then = min(self._states, key=lambda one: abs(one.stamp - frame.stamp))
        with vision.timed():
            self._work = self._executor.submit(
                self._refresh, self._surfaces, frame, then, held, moving
            )
        self._take_result()

    def relocalise(self, now: float) -> None:
        """Forget all frames from before session time `now` [s]."""
        self._since = now
        self._surfaces, self._work, self.cloud = SurfaceGrid(), None, NO_POINTS

    def _take_result(self) -> None:
        if self._work is not None and self._work.done():
            self.cloud, self._work = self._work.result(), None

    def _refresh(
        self,
        surfaces: SurfaceGrid,
        frame: DepthFrame,
        then: RobotState,
        held: Sequence[Geom],
        moving: Sequence[Geom],
    ) -> PointCloud:
        """The point cloud after one more frame."""
        oTe = frame.oTc * self._description.camera.eTc.inverse()
        own = [*self._robot(oTe, then), *(_enlarged(one).moved(oTe) for one in held)]
        ahead = [one for one in (*own, *moving) if _depth(one, frame) > 0.0]
        cells = surface_cells(frame)
        surfaces.update(frame, cells.of(~near(cells.points, ahead)))
        # The held object was seen before, where it was grasped.
        surfaces.keep(~near(surfaces.all_points, [one.moved(oTe) for one in held]))
        return PointCloud(surfaces.points)

    def _robot(self, oTe: OdometryPose, then: RobotState) -> list[Geom]:
        """The shapes of the robot in odometry; the hand by the pose of the camera."""
        robot = self._description
        oTh = oTe * robot.gripper.hTe.inverse()
        poses = (*self._model.link_poses(then.oTb, then.q)[:-2], oTh * robot.arm.lTh.inverse())
        links = zip(poses, robot.arm.collision, strict=True)
        x, y, z = (edge / 2.0 for edge in robot.base.size)
        base = Geom(Box((x, y, z)), SE3(np.eye(3), np.array([0.0, 0.0, z])))
        return [
            *(shape.moved(oTh) for shape in robot.gripper.collision),
            *(shape.moved(pose) for pose, shapes in links for shape in shapes),
            base.moved(then.oTb),
        ]


def _enlarged(held: Geom) -> Geom:
    """The space in e that a held object may fill."""
    half, _ = rounded_box(held.shape)
    x, y, z = held.pose.translation
    along, across = np.maximum(half[:2] + np.abs([x, y]), _HELD)
    top, bottom = z - half[2] - _HELD_ABOVE, z + half[2] + _HELD_BELOW
    centre = np.array([0.0, 0.0, (top + bottom) / 2.0])
    return Geom(Box((along, across, (bottom - top) / 2.0)), SE3(np.eye(3), centre), held.name)


def _depth(one: Geom, frame: DepthFrame) -> float:
    """Largest depth of a shape in the camera frame [m]."""
    centre = frame.oTc.actInv(one.pose.translation)
    return float(centre[2]) + bounding_radius(one.shape)


def near(points: Array, shapes: Sequence[Geom]) -> Mask:
    """Which of (N, 3) points are within the margin of a shape."""
    close = np.zeros(len(points), dtype=bool)
    for one in shapes:
        away = np.abs(points - one.pose.translation).max(axis=1, initial=0.0)
        (some,) = np.nonzero(away <= bounding_radius(one.shape) + _MARGIN)
        if len(some):
            local = (points[some] - one.pose.translation) @ one.pose.rotation
            close[some] |= from_rounded_boxes(local, *rounded_box(one.shape))[0] <= _MARGIN
    return close
