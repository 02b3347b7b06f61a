"""Release of the held object at a place: open, rise, and check that it stands there."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, radians, sin

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import way_out
from behaviours.core.leaf import Leaf
from behaviours.core.motion import BackOff, Progress
from behaviours.core.placed_object import PlacedObjectWatch, Verdict
from behaviours.views.viewpoint import CAMERA_PATIENCE
from config.arrays import Array
from config.poses import OdometryPose
from controller import PoseGoal
from hw import TaskTime
from robots import reach

TILT = radians(2.0)  # of the hand at the release [rad]
_CLEARANCE = 0.004  # of object and finger tips over the surface at the release [m]
_LET_GO = 0.02  # opening of the fingers from which the hand rises [m]
_LEAST_OPENING = 0.01  # of the fingers beyond the width of what they held [m]
_CLEAR = 0.04  # the fingers open fully once the hand is this high [m]
_RISE_SPEED = 0.5  # [m/s]
_RISE_TOLERANCE = 0.03  # [m]
_LOOK_ABOVE = 0.12  # the hand rises this much higher until the object is seen to stand [m]
_LAST_LOOK = 0.25  # so long a frame is awaited that shows it once the hand is up [s]
_DOWN, _SWAY = 0.06, 0.6  # then it sways down and up, by this [m], each way for so long [s]


def reach_down(context: Context) -> float:
    """How far the held object, or the finger tips, reach below the hand [m]."""
    return max(context.log.grip_height, context.robot.description.gripper.tip)


def release_height(context: Context) -> float:
    """Height of the hand over the surface at the release, with its largest tilt [m]."""
    gripper = context.robot.description.gripper
    outer = gripper.opening / 2.0 + reach(gripper.pad, np.array([0.0, 1.0, 0.0]))
    return reach_down(context) + _CLEARANCE + outer * sin(TILT)


@dataclass(frozen=True, eq=False)
class Spot:
    """The place of a release."""

    name: str
    """For messages."""
    centre: Array
    """(3,) on the surface, in odometry [m]."""
    radius: float
    """Of the disc around it that was seen to be free [m]."""
    heights: Array
    """(P,) seen through the points of that disc [m], see `SurfaceWatch`."""


class Release:
    """The fingers open, and the hand rises until it is seen whether the object stands.

    Args:
        leaf: sets the goals and gets the feedback message.
        goal: that the hand has reached, and keeps while the fingers open.
        spot: the place.
        up: how high the hand has to rise [m].
        backs_off: whether the base backs off afterwards.
        used: called when the object is released, even if the leaf has ended.
    """

    def __init__(
        self,
        leaf: Leaf,
        goal: PoseGoal[OdometryPose],
        *,
        spot: Spot,
        up: float,
        backs_off: bool,
        used: Callable[[], None],
    ) -> None:
        self._leaf, self._goal, self._spot, self._used = leaf, goal, spot, used
        self._up, self._backs_off = up, backs_off
        context = leaf.context
        assert context.log.in_hand is not None
        self._width, self._carried = context.state.gripper_width, context.log.in_hand
        self._watch: PlacedObjectWatch | None = None
        self._back_off: BackOff | None = None
        self._looking_since: TaskTime | None = None
        self._risen_at = inf
        self._step = self._open
        self._out = way_out(goal.target.rotation)
        high = goal.target.translation + (up + _LOOK_ABOVE) * self._out
        self._rising = replace(
            goal,
            target=SE3(goal.target.rotation, high),
            speed=_RISE_SPEED,
            hand_may_touch=True,
            base_rests=False,
        )
        self._lower = replace(
            self._rising, target=SE3(goal.target.rotation, high - _DOWN * self._out)
        )
        # What is gripped by its rim or handle has a part outside the fingers.
        room = context.log.grip_opening
        enough = None if room is None else max(room, self._width + _LEAST_OPENING)
        opens_by = leaf.let_go(enough)
        context.log.when_let_go(min(_LET_GO, opens_by), self._set_down)

    @property
    def phase(self) -> str:
        """`release`, then `rise`."""
        return "release" if self._step == self._open else "rise"

    def tick(self) -> Status:
        """Go on; SUCCESS when the object was seen standing."""
        return self._step()

    def _open(self) -> Status:
        self._leaf.pursue(self._goal)  # the hand keeps to the place, or it would coast on
        if self._watch is None and (waiting := self._wait_for_fingers("letting go")) is not None:
            return waiting
        if self._watch is None:
            self._set_down()
        self._progress = Progress(self._leaf.context, straight=True)
        self._step = self._rise
        return self._leaf.running("rising")

    def _set_down(self) -> None:
        context, log, spot = self._leaf.context, self._leaf.context.log, self._spot
        self._used()
        mTe = context.to_map(context.oTe)
        context.memory.set_down.add(self._width, log.grip_height, mTe, log.grip_outline)
        self._carried.let_go = context.clock.now()
        where = spot.centre, spot.radius, spot.heights
        self._watch = PlacedObjectWatch(context, self._carried, *where)
        context.memory.placed_object = self._watch

    def _rise(self) -> Status:
        """Up, and further up until the verdict is known, or the hand can rise no more."""
        leaf = self._leaf
        risen = float((leaf.context.oTe.translation - self._goal.target.translation) @ self._out)
        is_up = risen >= self._up - min(_RISE_TOLERANCE, self._up / 3.0)
        grip, opening = leaf.context.log.grip, leaf.context.robot.description.gripper.opening
        if risen >= _CLEAR and grip is not None and grip.target < opening:
            leaf.open_gripper()
        report = leaf.pursue(self._rising, "rising")
        if not (is_up and self._verdict is not Verdict.UNSEEN):
            if report is None or not (report.arrived or self._progress.is_stuck(report)):
                return leaf.running(f"rising, {risen:.2f} m up")
            if not is_up:
                return leaf.failure(f"rising: stuck {risen:.2f} m up" + self._progress.because)
        self._step = self._conclude
        return self._conclude()

    def _conclude(self) -> Status:
        leaf = self._leaf
        if (waiting := self._wait_for_fingers("opening")) is not None:
            return waiting
        if self._backs_off:
            self._back_off = self._back_off or BackOff(leaf)
            if not self._back_off.tick():
                return leaf.running("backing off")
        now, stamp = leaf.context.clock.now(), leaf.context.state.stamp
        if self._looking_since is None:
            self._looking_since, self._risen_at = now, stamp
        waited = now - self._looking_since
        if self._verdict is Verdict.STANDS:
            assert self._watch is not None
            awaited = waited <= _LAST_LOOK or self._watch.empty
            if self._watch.shown < self._risen_at and awaited:
                leaf.pursue(self._rising, "rising")
                return leaf.running("looking once more")
            if (other := self._watch.other) is not None:
                seen = f"something {other} stands at {self._spot.name}"
                return self._not_placed(f"{seen}, not what was {self._carried.colour}")
            return leaf.success(f"it stands at {self._spot.name}")
        if self._verdict is Verdict.GONE:
            here = SE3(np.eye(3), self._spot.centre)
            leaf.context.memory.set_down.grasp(leaf.context.to_map(here).translation)
            return self._not_placed(f"let go, but nothing stands at {self._spot.name}")
        if waited <= CAMERA_PATIENCE:
            # The hand moves down and up: a standing object does not move with it.
            leaf.pursue(self._lower if waited % (2.0 * _SWAY) < _SWAY else self._rising, "looking")
            return leaf.running("looking at what was set down")
        unseen = f"let go, but it is not seen whether it stands at {self._spot.name}"
        reason = leaf.context.vision.blindness(leaf.context.state.stamp)
        return self._not_placed(f"{unseen}: {reason}" if reason else unseen)

    def _not_placed(self, why: str) -> Status:
        """Fail; whatever is seen there later is not what was let go."""
        self._leaf.context.memory.placed_object, self._carried.placed = None, None
        return self._leaf.failure(why)

    @property
    def _verdict(self) -> Verdict:
        return Verdict.UNSEEN if self._watch is None else self._watch.verdict

    def _wait_for_fingers(self, what: str) -> Status | None:
        """None once they are open."""
        leaf = self._leaf
        if leaf.gripper_is_open:
            return None
        if (waiting := leaf.fingers(what)) is not None:
            return waiting
        width = 1000 * leaf.context.state.gripper_width
        return leaf.failure(f"not let go: the fingers stopped at {width:.0f} mm")
