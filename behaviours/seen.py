"""What the wrist camera has seen around the robot, without the robot and what it holds."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Executor, Future

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from behaviours.vision import Vision
from controller import Array, PointCloud, RobotModel
from hw import DepthFrame, InlineExecutor, RobotState
from perception import SurfaceGrid, SurfaceSettings, surface_cells
from robots import Box, Geom, RobotDescription, bounding_radius, from_rounded_boxes, rounded_box

FRAME_INTERVAL = 0.1
"""The camera is asked for a frame when nobody has asked for this long [s]."""
_MARGIN = 0.03
"""Points this near to the robot are the robot's own [m]."""
_MOST_STATES = 100
"""Readings that are kept, to know the posture in which a frame was taken."""
_HELD = (0.14, 0.10)
"""What is held reaches no farther than this along the pads and across them [m]: nobody has measured
how long it is."""
_HELD_ABOVE = 0.04
"""Nor farther than this above what is known of it ..."""
_HELD_BELOW = 0.03
"""... and below [m]."""


class SeenObstacles:
    """Keeps a cloud of points of what stands around, refreshed by frames.

    Args:
        description: of the robot.
        executor: where frames are worked on; inline, a run is the same every time.
        settings: what of a frame is believed, and for how long.
    """

    def __init__(
        self,
        description: RobotDescription,
        executor: Executor | None = None,
        settings: SurfaceSettings | None = None,
    ) -> None:
        self._description = description
        self._model = RobotModel(description)
        self._executor = executor or InlineExecutor()
        self._settings = settings or SurfaceSettings()
        self._surfaces = SurfaceGrid(self._settings)
        self._states: deque[RobotState] = deque(maxlen=_MOST_STATES)
        self._since = -np.inf
        self._frame: DepthFrame | None = None
        self._work: Future[PointCloud] | None = None
        self.cloud = _NOTHING
        """The points as they are known now."""

    def look(
        self,
        vision: Vision,
        state: RobotState,
        held: Sequence[Geom],
        moving: Sequence[Geom] = (),
    ) -> None:
        """Take the newest frame, if there is a new one.

        Args:
            vision: has it, or asks the camera for it.
            state: of this tick.
            held: shapes of what the hand holds, in e.
            moving: what is known to move, in the world: it would leave a trail.
        """
        self._states.append(state)
        self._take_result()
        if self._work is not None:
            return
        frame = vision.newest(state.stamp - FRAME_INTERVAL)
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
        """Forget all that frames from before session time `now` show: it is not where it was."""
        self._since = now
        self._surfaces, self._work, self.cloud = SurfaceGrid(self._settings), None, _NOTHING

    def close(self) -> None:
        """End the thread."""
        self._executor.shutdown(wait=False, cancel_futures=True)

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
        """What is around after one more frame."""
        wTe = frame.wTc * self._description.camera.eTc.inverse()
        own = [*self._robot(wTe, then), *(_generous(one).moved(wTe) for one in held)]
        ahead = [one for one in (*own, *moving) if _depth(one, frame) > 0.0]
        cells = surface_cells(frame, self._settings)
        surfaces.update(frame, cells.of(~_near(cells.points, ahead)))
        # What is held was seen before, where it was grasped.
        surfaces.keep(~_near(surfaces.all_points, [one.moved(wTe) for one in held]))
        return PointCloud(surfaces.points)

    def _robot(self, wTe: SE3, then: RobotState) -> list[Geom]:
        """The shapes of the robot in the world; the hand is where the camera says that it is."""
        robot = self._description
        wTh = wTe * robot.gripper.hTe.inverse()
        poses = (*self._model.link_poses(then.wTb, then.q)[:7], wTh * robot.arm.lTh.inverse())
        links = zip(poses, robot.arm.collision, strict=True)
        x, y, z = (edge / 2.0 for edge in robot.base.size)
        base = Geom(Box((x, y, z)), SE3(np.eye(3), np.array([0.0, 0.0, z])))
        return [
            *(shape.moved(wTh) for shape in robot.gripper.collision),
            *(shape.moved(pose) for pose, shapes in links for shape in shapes),
            base.moved(then.wTb),
        ]


_NOTHING = PointCloud(np.zeros((0, 3)))


def _generous(held: Geom) -> Geom:
    """The space in e that what is held can fill."""
    half, _ = rounded_box(held.shape)
    along, across = np.maximum(half[:2], _HELD)
    z = held.pose.translation[2]
    top, bottom = z - half[2] - _HELD_ABOVE, z + half[2] + _HELD_BELOW
    centre = np.array([*held.pose.translation[:2], (top + bottom) / 2.0])
    return Geom(Box((along, across, (bottom - top) / 2.0)), SE3(np.eye(3), centre), held.name)


def _depth(one: Geom, frame: DepthFrame) -> float:
    """How far ahead of the camera a shape reaches [m]; negative behind it."""
    centre = frame.wTc.actInv(one.pose.translation)
    return float(centre[2]) + bounding_radius(one.shape)


def _near(points: Array, shapes: Sequence[Geom]) -> npt.NDArray[np.bool_]:
    """Which of (N, 3) points are in a shape, or no farther from it than the margin."""
    near = np.zeros(len(points), dtype=bool)
    for one in shapes:
        away = np.abs(points - one.pose.translation).max(axis=1, initial=0.0)
        (some,) = np.nonzero(away <= bounding_radius(one.shape) + _MARGIN)
        if len(some):
            local = (points[some] - one.pose.translation) @ one.pose.rotation
            near[some] |= from_rounded_boxes(local, *rounded_box(one.shape))[0] <= _MARGIN
    return near
