"""Lift what was grasped and see whether it is really there."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.progress import Progress
from controller import PoseGoal


class RetreatCheck(Leaf):
    """Rise, and check on the way that the hand holds something.

    Fails when the fingers closed fully or the arm has a fault (Haviland 2022, section V), so that
    the tree tries again. Fingers that still close on the way up hold nothing: they are waited for.
    A grasp that failed is remembered and not chosen again while there are others.

    Args:
        rise_m: how far to lift the hand [m].
    """

    key: ClassVar[str] = "retreat_check"

    def __init__(self, name: str, context: Context, *, rise_m: float = 0.2) -> None:
        super().__init__(name, context)
        self._rise = rise_m

    def initialise(self) -> None:
        """Rise from wherever the hand is now."""
        here = self.context.wTe
        above = here.translation + np.array([0.0, 0.0, self._rise])
        wTe = SE3(here.rotation, above)
        retreat = self.settings.retreat
        self._goal = PoseGoal(
            wTe=wTe, speed=retreat.speed, position_tolerance=retreat.tolerance, straight=True
        )
        self._progress = Progress(self.settings.progress)

    def update(self) -> Status:
        """One tick."""
        context = self.context
        if fault := self.fault():
            return self._missed(fault)
        width = context.state.gripper_width
        if self.gripper_is_closed:
            return self._missed("the fingers closed on nothing")
        report = self.pursue(self._goal)
        if context.state.gripper_moving:
            return self.running("the fingers are slipping off")
        if report is not None and report.position_error <= self._goal.position_tolerance:
            context.vision.tracker.forget()
            return self.success(f"holding something {1000 * width:.0f} mm wide")
        if report is not None and self._progress.stalled(
            report.position_error, context.clock.now()
        ):
            return self._missed(f"stuck {report.position_error:.2f} m below the retreat")
        return self.running(f"rising, {1000 * width:.0f} mm between the fingers")

    def _missed(self, reason: str) -> Status:
        if self.context.log.last_grasp is not None:
            self.context.vision.tracker.reject(self.context.log.last_grasp)
        return self.failure(reason)
