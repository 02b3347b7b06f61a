"""Point the wrist camera at a place."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import numpy.typing as npt
from py_trees.common import Status

from behaviours.aiming import camera_pose, hand_for, is_at_rest, turned_towards
from behaviours.approach import Approach
from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.poses import Region, ToolPose
from behaviours.ranges import Distance, Seconds
from controller import PoseGoal
from perception import DetectedObject


class LookAt(Leaf):
    """Turn the hand until the camera looks at a place, base and arm moving as one.

    Sets out once the camera has delivered a frame. Fails when there is none, the robot has a fault,
    no longer comes nearer, or the time is over.

    Args:
        at: a tool pose or a region of the task file, or an object that `detect` found; its centre
            is looked at.
        distance_m: bring the camera this far from it, in the line of sight [m]; without it the
            camera turns where it is.
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
        timeout_s: Seconds = 30.0,
    ) -> None:
        super().__init__(name, context)
        self._at = at
        self._distance = distance_m
        self._timeout = timeout_s
        self._point = _middle(at)

    def initialise(self) -> None:
        """Start anew, from where the camera is now."""
        wTc = turned_towards(camera_pose(self.context), self._point, self._distance)
        goal = PoseGoal(wTe=hand_for(self.context, wTc), speed=self.settings.view.speed)
        target = f"a view of {self._at.name}"
        self._approach = Approach(self, goal, target, self._timeout)
        self._begun = self.context.clock.now()
        self._sees = False

    def update(self) -> Status:
        """One tick."""
        if not self._sees:
            return self._wait_for_frame()
        status = self._approach.tick()
        if status is not Status.SUCCESS:
            return status
        if not is_at_rest(self.context):  # the goal stays, or the camera would coast on
            return self.running("steadying the camera")
        return self.success(f"looking at {self._at.name}")

    def _wait_for_frame(self) -> Status:
        """RUNNING until there is a frame; the robot comes to rest meanwhile."""
        context = self.context
        if fault := self.fault():
            return self.failure(fault)
        context.vision.new_frame()
        blindness = context.vision.blindness(context.state.stamp)
        self._sees = not blindness
        if blindness and context.clock.now() - self._begun > self.settings.view.patience:
            return self.failure(blindness)
        return self.running("waiting for a frame")


def _middle(at: ToolPose | Region | DetectedObject) -> npt.NDArray[np.float64]:
    """(3,) what is looked at, in the world [m]."""
    if isinstance(at, DetectedObject):
        return at.position
    middle: npt.NDArray[np.float64] = (at.wTe if isinstance(at, ToolPose) else at.wTr).translation
    return middle
