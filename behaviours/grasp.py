"""Closed-loop grasping: follow one grasp with the camera, lock it, go down, close the fingers."""

from __future__ import annotations

from math import inf
from typing import ClassVar

import numpy as np
import numpy.typing as npt
from pinocchio import SE3
from py_trees.common import Status

from behaviours import misfits
from behaviours.aiming import back_over, sinking
from behaviours.another_view import AnotherView
from behaviours.approach import Approach
from behaviours.choice import Choice, Choose
from behaviours.context import Context
from behaviours.leaf import Leaf
from behaviours.poses import Region, ToolPose
from behaviours.progress import Progress
from behaviours.ranges import Distance, Force, Millimetres, Seconds
from behaviours.rise import Rise
from behaviours.target import Target
from controller import PoseGoal, StepReport
from perception import ColourName, DetectedObject, GraspEstimate

Array = npt.NDArray[np.float64]

_NOWHERE = np.full(3, np.inf)


class Grasp(Leaf):
    """Grasp an object seen in a region, following it until the camera is near.

    Which one may be chosen by its size, place, width and colour, among those that the camera sees
    when it begins; else it is the one with the best grasp. Where something stands and no grasp is
    seen, or only a doubtful one, the camera looks again from straight above. What moves steadily in
    a region is gripped where it will have come.

    Ends when the fingers have closed; whether they hold something is for `retreat_check` to say.
    Fails when no grasp is seen, frames come too late to be believed, the hand does not get there,
    the base was relocalised on the way down, the fingers do not move, the time is over, or the
    robot has a fault. A hand that has gone down rises before it fails.

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
        lock_distance_m: nearer than this to the camera the goal no longer moves [m].
        force_n: force of the fingers [N].
        onward: where the task goes next; once the grasp is locked, the base sets out for it. After
            an attempt in vain it stands.
        patience_s: give up after not seeing a grasp for this long [s].
        timeout_s: give up the whole attempt after this [s].
    """

    key: ClassVar[str] = "grasp"
    surfaces: ClassVar[tuple[str, ...]] = ("within",)
    misfit = staticmethod(misfits.of_grasp)
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
        lock_distance_m: Distance = 0.25,
        force_n: Force = 20.0,
        onward: ToolPose | None = None,
        patience_s: Seconds = 1.5,
        timeout_s: Seconds = 20.0,
    ) -> None:
        super().__init__(name, context)
        self._within = within
        choice = Choice.of(choose, kind, colour, min_width_mm, max_width_mm)
        self._aim = Target(context, within, choice, neighbour=neighbour)
        self._lock_distance = lock_distance_m
        self._force = force_n
        self._next = None if onward is None else onward.wTe
        self._placed_before = -1
        self._patience = patience_s
        self._timeout = timeout_s

    @property
    def phase(self) -> str:
        """`approach` until locked, `lock` until above it, `descend`, `close`; or else `rise`."""
        below = {self._descend: "descend", self._close: "close", self._rise: "rise"}
        above = "lock" if self.context.vision.tracker.locked else "approach"
        return below.get(self._step, above)

    def initialise(self) -> None:
        """Start to look."""
        self._begun = self._seen = self.context.clock.now()
        placed = self.context.log.placed
        is_first = placed != self._placed_before  # attempt at this object
        self._onward, self._placed_before = self._next if is_first else None, placed
        self._step = self._follow
        self._came_nearer = False
        self._looks = 0
        self._aim.begin()
        self._go_after(_NOWHERE)
        follows = self.context.follows_goals
        self.context.vision.tracker.lock_distance = self._lock_distance if follows else inf
        self.context.vision.reset()

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
        """Follow nothing any longer."""
        self.context.vision.reset()

    def _follow(self) -> Status:
        """Keep over the grasp that perception follows, until it is locked and below the hand."""
        vision, now, settings = self.context.vision, self.context.clock.now(), self.settings.grasp
        read = self.context.state.stamp  # frames have the session's time, which a pause adds to
        if self.context.relocalised:  # what was seen before is not where it was
            vision.relocalise(read)
            self._aim.begin(read)
        grasp = self._aim.track(read)
        if grasp is None:
            if now - self._seen > self._patience:
                if vision.detection is not None and vision.detection.grasps:
                    vision.tracker.forget()  # every grasp in sight failed once: try them again
                if self._looks_again(None if vision.is_blind(read) else self._aim.middle()):
                    return self._look()
                reason = vision.blindness(read) or self._aim.reason or vision.tracker.reason
                return self.failure(f"no grasp for {self._patience:g} s: {reason}")
            return self.running("looking for a grasp")
        self._seen = now
        wTg = grasp.wTg_at(read)
        above = wTg * SE3(np.eye(3), np.array([0.0, 0.0, -settings.standoff]))
        if np.linalg.norm(wTg.translation - self._target) > settings.other_target:
            self._go_after(wTg.translation)
        report = self.pursue(
            PoseGoal(
                wTe=above,
                twist=grasp.twist,
                speed=settings.follow_speed,
                straight=True,
                hand_may_touch=True,
                onward=self._onward if vision.tracker.locked else None,
            ),
            "follow",
        )
        if report is None:
            return self.running(f"following a grasp of quality {grasp.quality:.2f}")
        if self._progress.is_stuck(report):
            if not self._came_nearer:
                return self._leave_for(grasp)
            vision.reject()
            short = f"cannot get above the grasp, {report.position_error:.3f} m short"
            return self.failure(short + self._progress.because)
        if not vision.tracker.locked:
            return self.running(f"following, {report.position_error:.3f} m to go")
        is_above = report.position_error <= settings.above_position
        if not is_above or report.orientation_error > settings.above_angle:
            return self.running(f"locked, {report.position_error:.3f} m to go")
        if grasp.quality < settings.doubtful and self._looks_again(grasp.wTg.translation):
            return self._look()
        self.grip(grasp.opening, self._force)
        self._locked = grasp
        self._progress = Progress(self.context, straight=True)
        self._step = self._descend
        return self._descend()

    def _looks_again(self, point: Array | None) -> bool:
        """Whether there is something to look at, (3,) in the world [m], and a look left."""
        if point is None or self._looks == self.settings.grasp.looks:
            return False
        self._looks += 1
        self._view = AnotherView(self, point, self._timeout)
        self._step = self._look
        return True

    def _look(self) -> Status:
        """Go to look from above; from as far as the camera gets."""
        if self._view.tick() is Status.RUNNING:
            return Status.RUNNING
        self._look_anew()
        return self._follow()

    def _look_anew(self) -> None:
        """Follow what is seen from here."""
        self.context.vision.reset()
        self._seen = self.context.clock.now()
        self._go_after(_NOWHERE)
        self._step = self._follow

    def _leave_for(self, grasp: GraspEstimate) -> Status:
        """The grasp is out of reach from here: have the base come to it from elsewhere, once."""
        settings = self.settings.grasp
        up = SE3(np.eye(3), np.array([0.0, 0.0, -settings.nearer_standoff]))
        goal = PoseGoal(
            wTe=grasp.wTg * up,
            speed=settings.follow_speed,
            position_tolerance=settings.nearer_tolerance,
            stance_if_near=True,
        )
        self._nearer = Approach(self, goal, "a stance nearer to it", self._timeout)
        self._came_nearer, self._step = True, self._come_nearer
        return self._come_nearer()

    def _come_nearer(self) -> Status:
        status = self._nearer.tick()
        if status is Status.SUCCESS:
            self._look_anew()
            return self._follow()
        if status is Status.FAILURE:
            self.context.vision.reject()
            return self.failure(f"cannot get above the grasp: {self.feedback_message}")
        return status

    def _go_after(self, target: Array) -> None:
        """Another grasp gets the full time to be reached."""
        self._target = target
        self._progress = Progress(self.context, straight=True)

    def _descend(self) -> Status:
        """Straight down on the locked grasp, which goes on as it moved."""
        if self.context.relocalised:
            return self._give_up(self.context.relocalised)
        report = self._go_down()
        if (
            report is None
            or not report.arrived
            or sinking(self.context) > self.settings.grasp.closing_speed
        ):
            if report is not None and self._progress.is_stuck(report):
                self.context.vision.reject()
                short = f"stopped {report.position_error:.3f} m before the grasp"
                return self._give_up(short + self._progress.because)
            return self.running("going down")
        wTg, log = self._locked.wTg_at(self.context.state.stamp), self.context.log
        log.last_grasp = wTg
        log.grip_height = float(wTg.translation[2]) - self._within.floor
        self.context.set_down.grasp(wTg.translation)
        self.grip(0.0, self._force)
        self._step = self._close
        return self.running("closing")

    def _close(self) -> Status:
        """Wait for the fingers; the hand keeps to the grasp, or it would coast on."""
        self._go_down()
        waiting = self.fingers("closing")
        if waiting is Status.FAILURE:
            return self._give_up(self.feedback_message)
        if waiting is not None:
            return waiting
        self.context.log.attempt(self._begun, self.context.clock.now())
        return self.success(f"closed at {1000 * self.context.state.gripper_width:.0f} mm")

    def _give_up(self, reason: str) -> Status:
        """Fail as soon as the hand is out from among things: what is next may go sideways."""
        self._reason, self._up = reason, Rise(self, self.settings.grasp.standoff)
        self._step = self._rise
        return self._rise()

    def _rise(self) -> Status:
        if self._up.tick():
            return self.failure(self._reason)
        return self.running(f"rising, as {self._reason}")

    def _go_down(self) -> StepReport | None:
        settings = self.settings.grasp
        goal = PoseGoal(
            wTe=back_over(self._locked.wTg_at(self.context.state.stamp), self.context),
            twist=self._locked.twist,
            speed=settings.descend_speed,
            position_tolerance=settings.descend_tolerance,
            straight=True,
            hand_may_touch=True,
            onward=self._onward,
        )
        return self.pursue(goal, "descend")
