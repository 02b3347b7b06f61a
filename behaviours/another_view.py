"""Another view of what shall be grasped: from straight above."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from py_trees.common import Status

from behaviours.aiming import camera_pose, hand_for, is_at_rest, straight_down
from behaviours.approach import Approach
from behaviours.leaf import Leaf
from controller import PoseGoal


class AnotherView:
    """The way of the camera to where it looks straight down on a place.

    Args:
        leaf: whose way it is.
        point: (3,) what is looked at, in the world [m].
        timeout: look from wherever the camera is after this [s].
    """

    def __init__(self, leaf: Leaf, point: npt.NDArray[np.float64], timeout: float) -> None:
        self._leaf = leaf
        wTc = straight_down(point, leaf.settings.grasp.look_height, like=camera_pose(leaf.context))
        goal = PoseGoal(wTe=hand_for(leaf.context, wTc), speed=leaf.settings.view.speed)
        self._approach = Approach(leaf, goal, "another view", timeout)

    def tick(self) -> Status:
        """Go on; SUCCESS when the camera rests there, FAILURE when it comes no nearer."""
        status = self._approach.tick()
        if status is Status.SUCCESS and not is_at_rest(self._leaf.context):
            return self._leaf.running("steadying the camera")
        return status
