"""Behaviour `navigate`: base and arm to a tool pose, or the base to a base pose."""

from dataclasses import replace
from typing import Annotated, ClassVar

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.core.motion import METRES_PER_RADIAN, Approach, BackOff
from behaviours.core.parameter_types import BasePose, Bounds, Speed, Timeout, ToolPose
from behaviours.core.reachable_directions import tilted_if_needed
from behaviours.views.viewpoint import camera_pose, hand_for, looking_along
from config.poses import OdometryPose
from controller import BaseGoal, MotionGoal, PoseGoal, StepReport
from perception import DetectedObject

_OVER_OBJECT = 0.4  # distance of the camera from a detected object [m]
_AHEAD, _AHEAD_TIME = 0.1, 0.5  # how far before the hand a straight way leads it, at least [m, s]


class Navigate(Leaf):
    """Move the end effector, or the base, to a named pose.

    A robot that is stuck beside something backs off once and tries again. Fails when it has a
    fault, no longer comes nearer, or the time is over.

    Args:
        to: a pose of the task file; a tool pose moves base and arm as one, a base pose the base.
            Or an object that `detect` found: the camera gets over it, and looks down on it as the
            hand comes to its region.
        speed_m_s: largest speed of the end effector, or of the base [m/s].
        within_m: a tool this near to its pose is there, or from 5 cm on a base, and what follows
            begins on the move [m]; it may then be turned by as much as swings a hand's length that
            far. From 5 cm on, a hand that looks down is tilted as far as it must be for a stance to
            reach its pose.
        straight: the hand keeps to the straight line from where it is, at its speed, and the base
            comes after it; fails when it is farther beside the line than `within_m`.
        next_goal: where the task goes next; the base stands so that it is soon on its way there.
        timeout_s: give up after this [s].
    """

    key: ClassVar[str] = "navigate"
    goes_to: ClassVar[tuple[str, ...]] = ("to",)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        to: ToolPose | BasePose | DetectedObject,
        speed_m_s: Speed = 1.0,
        within_m: Annotated[float, Bounds(least=0.001, most=1.0)] = 0.01,
        straight: bool = False,
        next_goal: ToolPose | None = None,
        timeout_s: Timeout = 60.0,
    ) -> None:
        super().__init__(name, context)
        self._straight = straight
        if isinstance(to, ToolPose):
            to = tilted_if_needed(context.robot.description, context.around.fixtures, to, within_m)
        self._to = to
        self._next = next_goal
        self._timeout = timeout_s
        self._speed, self._within = speed_m_s, within_m

    def initialise(self) -> None:
        """Start anew."""
        self._like = camera_pose(self.context)
        self._start, self._astray = self.context.oTe.translation, 0.0
        if isinstance(self._to, DetectedObject):
            self._direction = self.context.direction_now(self._to)
        self._approach = Approach(self, self._goal, self._to.name, self._timeout)
        self._back_off: BackOff | None = None
        self._has_backed_off = self._straight

    def update(self) -> Status:
        """One tick."""
        if self._back_off is not None:
            if not self.fault() and not self._back_off.tick():
                return self.running("backing off")
            self._back_off = None
            self._approach = Approach(self, self._goal, self._to.name, self._timeout)
        status = self._approach.tick()
        if self._astray > self._within:
            far = f"{1000 * self._astray:.0f} mm"
            return self.failure(f"{far} beside the straight way to {self._to.name}")
        if status is Status.FAILURE and self._approach.is_blocked and not self._has_backed_off:
            self._back_off, self._has_backed_off = BackOff(self), True
            return self.running("backing off")
        return status

    def pursue(self, goal: MotionGoal[OdometryPose], phase: str = "") -> StepReport | None:
        """As every leaf; on a straight way the hand is led by a point of the line before it."""
        if not (self._straight and isinstance(goal, PoseGoal)):
            return super().pursue(goal, phase)
        there = goal.target.translation
        way, here = there - self._start, self.context.oTe.translation - self._start
        length = max(float(np.linalg.norm(way)), 1e-9)
        done = float(np.clip(here @ way / length, 0.0, length))
        self._astray = float(np.linalg.norm(here - way * done / length))
        left = max(0.0, length - done - max(_AHEAD, _AHEAD_TIME * self._speed))
        before = SE3(goal.target.rotation, there - way * left / length)
        report = super().pursue(replace(goal, target=before, twist=np.zeros(6)), phase)
        if report is None or not left:
            return report
        return report._replace(arrived=False, position_error=report.position_error + left)

    def _goal(self) -> MotionGoal[OdometryPose]:
        """Where to go, by the newest estimate of where the map is."""
        to = self._to
        if isinstance(to, BasePose):
            return BaseGoal(
                target=to.oTb,
                speed=self._speed,
                position_tolerance=max(BaseGoal.position_tolerance, self._within),
                heading_tolerance=max(BaseGoal.heading_tolerance, self._within / METRES_PER_RADIAN),
            )
        if isinstance(to, ToolPose):
            oTe = to.oTe
        else:
            over = looking_along(self._direction, to.position, _OVER_OBJECT, like=self._like)
            oTe = hand_for(self.context, over)
        return PoseGoal(
            target=oTe,
            speed=self._speed,
            straight=self._straight,
            next_goal=getattr(self._next, "oTe", None),
            position_tolerance=self._within,
            orientation_tolerance=max(
                PoseGoal.orientation_tolerance, self._within / METRES_PER_RADIAN
            ),
        )
