"""Behaviour `look_at`: point the wrist camera at a place."""

from typing import ClassVar

from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import DOWN
from behaviours.core.leaf import Leaf
from behaviours.core.parameter_types import Distance, Region, Timeout, ToolPose
from behaviours.views.viewpoint import (
    CAMERA_PATIENCE,
    MoveCamera,
    camera_pose,
    looking_along,
    turned_towards,
)
from config.arrays import Array
from perception import DetectedObject


class LookAt(Leaf):
    """Turn the hand until the camera looks at a place, base and arm moving as one.

    Sets out once the camera has delivered a frame. Fails when there is none, the robot has a fault,
    no longer comes nearer, or the time is over.

    Args:
        at: a tool pose or a region of the task file, or an object that `detect` found; its centre
            is looked at.
        distance_m: bring the camera this far from it, in the line of sight [m], and look down on a
            region or an object by 75 degrees or more; without it the camera turns where it is.
        timeout_s: give up after this [s].
    """

    key: ClassVar[str] = "look_at"

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        at: ToolPose | Region | DetectedObject,
        distance_m: Distance | None = None,
        timeout_s: Timeout = 30.0,
    ) -> None:
        super().__init__(name, context)
        self._at, self._distance, self._timeout = at, distance_m, timeout_s
        self._way_in = context.direction(at) if isinstance(at, Region) else DOWN

    def initialise(self) -> None:
        """Start from the camera's present pose."""
        point = _centre(self._at)
        now, is_far = camera_pose(self.context), self._distance is not None
        oTc = turned_towards(
            now, point, self._distance, from_above=is_far and not isinstance(self._at, ToolPose)
        )
        if self._distance is not None and not isinstance(self._at, ToolPose):
            direction = self.context.direction_now(self._at, self._way_in)
            if not direction.is_straight:
                oTc = looking_along(direction, point, self._distance, like=now)

        def view() -> SE3:  # places of the task move in odometry as it is corrected
            return SE3(oTc.rotation, oTc.translation + _centre(self._at) - point)

        self._camera = MoveCamera(self, view, f"a view of {self._at.name}", self._timeout)
        self._begun = self.context.clock.now()
        self._sees = False

    def update(self) -> Status:
        """One tick."""
        if not self._sees:
            return self._wait_for_frame()
        status = self._camera.tick()
        return self.success(f"looking at {self._at.name}") if status is Status.SUCCESS else status

    def _wait_for_frame(self) -> Status:
        """RUNNING until there is a frame; the robot comes to rest meanwhile."""
        context = self.context
        if fault := self.fault():
            return self.failure(fault)
        context.vision.new_frame()
        blindness = context.vision.blindness(context.state.stamp)
        self._sees = not blindness
        if blindness and context.clock.now() - self._begun > CAMERA_PATIENCE:
            return self.failure(blindness)
        return self.running("waiting for a frame")


def _centre(at: ToolPose | Region | DetectedObject) -> Array:
    """(3,) in odometry [m]."""
    if isinstance(at, DetectedObject):
        return at.position
    centre: Array = (at.oTe if isinstance(at, ToolPose) else at.oTr).translation
    return centre
