"""Behaviour `grasp`: track a grasp with the camera, lock it, go down, close the fingers."""

from dataclasses import replace
from math import radians
from typing import ClassVar

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.arguments import validate_grasp
from behaviours.core.context import Context
from behaviours.core.directions import ApproachWord
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Approach, Progress, Rise, closing_in_speed, over_grasp
from behaviours.core.parameter_types import (
    Distance,
    Force,
    Millimetres,
    Region,
    Tilt,
    Timeout,
    ToolPose,
)
from behaviours.views.grasp_target import GraspTarget, OtherViews
from behaviours.views.objects import Choice, Choose
from behaviours.views.surface import floor_error
from behaviours.views.survey import note_fallen
from config.poses import OdometryPose
from controller import Array, PoseGoal, StepReport
from perception import ColourName, DetectedObject, GraspEstimate

_STANDOFF = 0.12  # before the grasp, back along the approach, where the hand awaits the lock [m]
_NEAR, _ALIGNED = 0.009, radians(3.0)  # errors there from which it goes down [m, rad]
_OTHER_TARGET = 0.03  # a grasp that jumps this far is another one [m]
_STANCE_STANDOFF, _STANCE_TOLERANCE = 0.24, 0.03  # the same, of a base that comes nearer [m]
_FOLLOW_SPEED, _DESCEND_SPEED = 0.5, 0.25  # of the hand, to there and from there [m/s]
_DESCEND_TOLERANCE = 0.004  # the fingers close when the grasp is nearer than this [m]
_CLOSING_SPEED = 0.015  # and the hand slower: a faster one presses the object down [m/s]
_NOWHERE = np.full(3, np.inf)


class Grasp(Leaf):
    """Grasp an object seen in a region, following it until the camera is near.

    It may be chosen by size, place, width and colour, among those that the camera sees when it
    begins; else it has the best grasp. Where no grasp, or only a doubtful one, is seen, the camera
    looks again, a tilted one from the sides, too. What moves steadily is gripped where it will be.

    Ends when the fingers have closed; `retreat_check` checks what they hold. Fails when no grasp is
    seen, frames come too late, the hand does not get there, the base was relocalised on the way
    down, the fingers do not move or the time is over; a low hand rises first. A fault fails it now.

    Args:
        within: region of the task file that the grasp must lie in, or an object that `detect`
            found.
        choose: which of those that fit; the largest covers most, seen from above, and the nearest
            is near to the base.
        kind: only objects of this kind: `box`, `can`, `ball`, `roll`, or what a package recognises.
        colour: only objects of this colour.
        min_width_mm: only those whose shorter edge, seen from above, is at least this [mm].
        max_width_mm: only those whose shorter edge is at most this [mm].
        neighbour: take something that stands beside what is chosen instead of it, so that there is
            room for the hand.
        approach: how the hand comes: straight `down`, `tilted` by 15 to 75 degrees, `level` (75 or
            more), or `auto`, by the least tilt that reaches all of the region.
        least_tilt_deg: at least this tilt from straight down [deg], as to set down under a board.
        lock_distance_m: nearer than this to the camera the goal no longer moves [m].
        force_n: force of the fingers [N].
        next_goal: where the task goes next; once the grasp is locked, the base sets out for it.
            After an attempt in vain it stands.
        patience_s: give up after not seeing a grasp for this long [s].
        timeout_s: give up the whole attempt after this [s].
    """

    key: ClassVar[str] = "grasp"
    hand_before: ClassVar[str] = "empty"
    hand_after: ClassVar[str] = "full"
    opens_for: ClassVar[tuple[str, ...]] = ("min_width_mm",)
    surfaces: ClassVar[tuple[str, ...]] = ("within",)
    validate = staticmethod(validate_grasp)
    _progress: Progress

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        within: Region | DetectedObject,
        choose: Choose = "best",
        kind: str | None = None,
        colour: ColourName | None = None,
        min_width_mm: Millimetres | None = None,
        max_width_mm: Millimetres | None = None,
        neighbour: bool = False,
        approach: ApproachWord = "auto",
        least_tilt_deg: Tilt = 0.0,
        lock_distance_m: Distance = 0.25,
        force_n: Force = 40.0,
        next_goal: ToolPose | None = None,
        patience_s: Timeout = 1.5,
        timeout_s: Timeout = 20.0,
    ) -> None:
        super().__init__(name, context)
        self._within = within
        choice = Choice.of(choose, kind, colour, min_width_mm, max_width_mm)
        self._colour = colour
        self._sought = GraspTarget(context, within, choice, neighbour=neighbour)
        self._way = context.direction(within, approach, radians(least_tilt_deg))
        self._lock_distance, self._force = lock_distance_m, force_n
        self._next = next_goal
        self._placed_before = -1
        self._patience, self._timeout = patience_s, timeout_s

    @property
    def phase(self) -> str:
        """`approach` until locked, `lock` until above it, `descend`, `close`; or else `rise`."""
        below = {self._descend: "descend", self._close: "close", self._rise: "rise"}
        above = "lock" if self.context.vision.tracker.locked else "approach"
        return below.get(self._step, above)

    def initialise(self) -> None:
        """Start to look."""
        self._begun = self._seen = self.context.clock.now()
        self._looked = self.context.state.stamp
        self._has_counted = self._came_nearer = False
        placed = self.context.log.placed
        is_first = placed != self._placed_before  # attempt at this object
        self._next_now, self._placed_before = self._next if is_first else None, placed
        self._step = self._follow
        self._sought.begin()
        self._go_after(_NOWHERE)
        way, vision = self._way, self.context.vision
        self._views = OtherViews(self, self._sought, self._within, way, self._timeout)
        vision.tracker.lock_distance = self._lock_distance
        vision.reset(self._views.oRa)

    def update(self) -> Status:
        """One tick of the phase that the grasp is in."""
        if fault := self.fault():
            self.context.vision.reject()
            return self.failure(fault)
        is_late = self.context.clock.now() - self._begun > self._timeout
        if is_late and self._step != self._rise:
            late = f"not done after {self._timeout:g} s"
            is_down = self._step in (self._descend, self._close)
            return self._give_up(late) if is_down else self.failure(late)
        return self._step()

    def terminate(self, new_status: Status) -> None:
        """Stop tracking."""
        self.context.vision.reset()

    def _follow(self) -> Status:
        """Keep before the grasp that perception follows, until it is locked; then go down on it."""
        vision, read = self.context.vision, self.context.state.stamp
        if self.context.now.relocalised:  # what was seen before is not where it was
            vision.relocalise(read)
            self._sought.begin(read)
        grasp = self._sought.track(read)
        if not self._has_counted and (frame := vision.picture(read)) is not None:
            self._has_counted = True
            note_fallen(self.context, frame)
        if grasp is None:
            return self._without_grasp()
        self._seen, self._looked = self.context.clock.now(), read
        oTg = grasp.oTg_at(read)
        if np.linalg.norm(oTg.translation - self._target) > _OTHER_TARGET:
            self._go_after(oTg.translation)
        goal = self._goal(_before(oTg, _STANDOFF), grasp, _FOLLOW_SPEED)
        if (report := self.pursue(goal, "follow")) is None:
            return self.running(f"following a grasp of quality {grasp.quality:.2f}")
        is_there = report.position_error <= _NEAR and report.orientation_error <= _ALIGNED
        if is_there and not vision.tracker.locked:
            return self.running("over the grasp, waiting for a picture that locks it")
        if self._progress.is_stuck(report):
            return self._leave_for(grasp, report.position_error)
        if not is_there:
            word = "locked" if vision.tracker.locked else "following"
            return self.running(f"{word}, {report.position_error:.3f} m to go")
        if grasp.quality < self._views.doubtful and self._views.begin(grasp.oTg.translation):
            return self._look()
        return self._begin_descent(grasp)

    def _without_grasp(self) -> Status:
        """No grasp is seen: look from elsewhere, or wait for the next picture."""
        vision, read = self.context.vision, self.context.state.stamp
        if self._views.begin_if_lost(self._target):
            return self._look()
        waits = not self._sought.reason and vision.waits_for_search(self._looked, read)
        if waits or self.context.clock.now() - self._seen <= self._patience:
            return self.running(f"looking for a grasp: {vision.blindness(read)}".removesuffix(": "))
        if vision.detection is not None and vision.detection.grasps:
            vision.tracker.forget()  # every grasp in sight failed once: try them again
        if self._views.begin():
            return self._look()
        reason = vision.blindness(read) or self._sought.reason or vision.tracker.reason
        return self.failure(f"no grasp for {self._patience:g} s: {reason}")

    def _begin_descent(self, grasp: GraspEstimate) -> Status:
        """Open the fingers as far as the grasp asks, and go down."""
        self.grip(grasp.opening, self._force)
        read = self.context.state.stamp
        seen, oTg = self.context.vision.picture(read), grasp.oTg_at(read)
        self.context.log.floor_error = floor_error(seen, oTg.translation, self._within)
        self._progress = Progress(self.context, straight=True)
        self._locked, self._step = grasp, self._descend
        return self._descend()

    def _look(self) -> Status:
        """Move the camera to another view, as far as it gets."""
        self._step = self._look
        if self._views.tick() is Status.RUNNING:
            return Status.RUNNING
        return self._look_anew()

    def _look_anew(self) -> Status:
        """Track what is seen from here."""
        self.context.vision.reset(self._views.oRa)
        self._seen, self._looked = self.context.clock.now(), self.context.state.stamp
        self._go_after(_NOWHERE)
        self._step = self._follow
        return self._follow()

    def _leave_for(self, grasp: GraspEstimate, short: float) -> Status:
        """Move the base to another stance, once, as the hand gets stuck short of the grasp [m]."""
        if self._came_nearer:
            self.context.vision.reject()
            why = f"{short:.3f} m short{self._progress.because}"
            return self.failure(f"cannot get above the grasp, {why}")
        goal = PoseGoal(
            target=_before(grasp.oTg_at(self.context.state.stamp), _STANCE_STANDOFF),
            speed=_FOLLOW_SPEED,
            position_tolerance=_STANCE_TOLERANCE,
            stance_if_near=True,
        )
        self._stance = Approach(self, goal, "a stance nearer to it", self._timeout)
        self._came_nearer, self._step = True, self._come_nearer
        return self._come_nearer()

    def _come_nearer(self) -> Status:
        status = self._stance.tick()
        if status is Status.SUCCESS:
            return self._look_anew()
        if status is Status.FAILURE:
            self.context.vision.reject()
            return self.failure(f"cannot get above the grasp: {self.feedback_message}")
        return status

    def _go_after(self, target: Array) -> None:
        """Give another grasp the full time to be reached."""
        self._target = target
        self._progress = Progress(self.context, straight=True)

    def _descend(self) -> Status:
        """Straight down on the locked grasp, which keeps its velocity."""
        if self.context.now.relocalised:
            return self._give_up(self.context.now.relocalised)
        if (report := self._go_down()) is None:
            return self.running("going down")
        if not report.arrived or closing_in_speed(self.context) > _CLOSING_SPEED:
            if self._progress.is_stuck(report):
                self.context.vision.reject()
                short = f"stopped {report.position_error:.3f} m before the grasp"
                return self._give_up(short + self._progress.because)
            return self.running("going down")
        oTg, log = self._locked.oTg_at(self.context.state.stamp), self.context.log
        log.last_grasp = oTg
        log.grip_height = float(oTg.translation[2]) - self._within.floor
        log.grip_outline, log.grip_opening = self._locked.outline, self._locked.opening
        self.context.memory.set_down.grasp(self.context.to_map(oTg).translation)
        self.grip(0.0, self._force)
        self._step = self._close
        return self.running("closing")

    def _close(self) -> Status:
        """Wait for the fingers; the hand keeps its goal."""
        self._go_down()
        if (waiting := self.fingers("closing")) is Status.FAILURE:
            return self._give_up(self.feedback_message)
        if waiting is not None:
            return waiting
        self.context.log.attempt(self._begun, self.context.clock.now(), self._colour)
        return self.success(f"closed at {1000 * self.context.state.gripper_width:.0f} mm")

    def _give_up(self, reason: str) -> Status:
        """Rise, then fail: the next motion may go sideways."""
        self._reason, self._up, self._step = reason, Rise(self, _STANDOFF), self._rise
        return self._rise()

    def _rise(self) -> Status:
        if self._up.tick():
            return self.failure(self._reason)
        return self.running(f"rising, as {self._reason}")

    def _go_down(self) -> StepReport | None:
        target = over_grasp(self._locked.oTg_at(self.context.state.stamp), self.context)
        goal = self._goal(target, self._locked, _DESCEND_SPEED)
        return self.pursue(replace(goal, position_tolerance=_DESCEND_TOLERANCE), "descend")

    def _goal(self, target: SE3, grasp: GraspEstimate, speed: float) -> PoseGoal[OdometryPose]:
        """The goal at, or before, a grasp; once that is locked the base may set out, or rest."""
        locked, onward = self.context.vision.tracker.locked, self._next_now
        return PoseGoal(
            target=target,
            twist=grasp.twist,
            speed=speed,
            straight=True,
            hand_may_touch=True,
            base_rests=locked and self._views.oRa is not None,
            next_goal=onward.oTe if locked and onward is not None else None,
        )


def _before(oTg: OdometryPose, distance: float) -> SE3:
    """A hand that is so far back along its approach to a grasp."""
    return oTg * SE3(np.eye(3), np.array([0.0, 0.0, -distance]))
