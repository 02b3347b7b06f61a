"""Behaviour `place`: set the held object down on a free place of a region."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.context import Context
from behaviours.core.directions import upright, way_out
from behaviours.core.held_object import reach_on_surface
from behaviours.core.leaf import Leaf
from behaviours.core.motion import Progress
from behaviours.core.parameter_types import Pitch, Region
from behaviours.core.reachable_directions import room_above
from behaviours.places import Places
from behaviours.release import TILT, Release, Spot, reach_down, release_height
from behaviours.views.surface import Edge, Shows, SurfaceWatch
from behaviours.views.viewpoint import CAMERA_PATIENCE, out_of_view
from controller import Array, PoseGoal, StepReport
from hw import FaultKind, TaskTime

_MOST_RELOCALISATIONS = 3  # after which the hand goes back over the place
_MOST_UNSEEN = 1  # places that are skipped as they are not seen
_MOST_STUCK = 1  # places that are skipped as the hand does not get there
_ABOVE, _LEAST_ABOVE = 0.12, 0.06  # height over the place, and where that is out of reach [m]
_BOARD, _BARELY = 0.5, np.array([0.0, 0.0, 0.03])  # below what is so near, it comes in so high [m]
_APPROACH_SPEED, _APPROACH_TOLERANCE = 0.6, 0.015  # [m/s, m]
_LOWER_SPEED, _LOWER_TOLERANCE = 0.25, 0.007  # [m/s, m]
_RADIUS = 0.06  # of the disc around the place that has to be free [m] ...
_PITCH_SHARE = 0.45  # ... and most of the distance between places, by which one is moved, too
_OFF_EDGE = 0.005  # by which a place that is too near to an edge is moved farther [m]


class Place(Leaf):
    """Set the held object down on the next free place of a region and rise.

    The camera has to see nearly all of the floor at the place before the hand is lowered. A place
    at a seen edge is moved off it, and passed over if that is too far; so is one on which something
    stands, or that is not seen. Rows far from the base are filled first, near ones if a hand that
    points down works above the shoulder. What a tilted hand gripped is set down with that tilt;
    below a board the base carries it in. The hand stops as high above the floor as it was above
    what the object stood on, by the camera where the map is wrong, and a little higher. A place at
    which lowering failed is not tried again, one that was not seen only after the others. Fails
    when nothing is held, no place is free, seen or reached, the fingers do not open, or on a fault.

    Args:
        on: region of the task file whose floor is the surface to place on.
        pitch_m: distance between neighbouring places; half of it when the rows are full [m].
    """

    key: ClassVar[str] = "place"
    surfaces: ClassVar[tuple[str, ...]] = ("on",)

    def __init__(self, name: str, context: Context, *, on: Region, pitch_m: Pitch = 0.2) -> None:
        super().__init__(name, context)
        self._on, self._way_in = on, context.direction(on)
        robot = context.robot.description
        shoulder = float((robot.bTa * robot.arm.joints[0]).translation[2])
        self._is_high = self._way_in.is_straight and on.floor > shoulder
        """Whether the arm depends on its stance: straight down on what is above the shoulder."""
        self._is_below = room_above(on, context.fixtures) < _BOARD
        self._goes_straight = not (self._is_high or self._is_below)  # until it gets stuck
        self._places = Places(context, on, pitch_m, far_first=not self._is_high)
        self._most_moved = _PITCH_SHARE * min(pitch_m, *on.size[:2])
        self._radius = min(_RADIUS, self._most_moved)

    @property
    def phase(self) -> str:
        """`approach` until the hand is over the place, then `lower`, `release` and `rise`."""
        if self._step == self._let_go:
            return self._releasing.phase
        return "lower" if self._step == self._lower else "approach"

    def initialise(self) -> None:
        """Choose the place."""
        self._step = self._begin
        self._progress = Progress(self.context)
        self._relocalised = self._unseen = self._stuck = 0
        self._places.begin()
        now, way_in = self.context.wTe.rotation, self._way_in.turned(self._on.wTm)
        self._rotation = upright(self.context.log.last_grasp, now, way_in)
        self._choose()

    def update(self) -> Status:
        """One tick of the phase that the placing is in."""
        if fault := self.fault():
            if any(one.kind is FaultKind.REFLEX for one in self.context.state.faults):
                self._block()
            return self.failure(fault)
        if self._step in (self._approach, self._give_way, self._lower) and (reason := self._look()):
            return self.failure(reason)
        return self._step()

    def _choose(self) -> None:
        """Aim at the next free place, moved off what was set down beside it."""
        self._number = self._places.next_free()
        self._up = _ABOVE
        self._inwards = self._places.beside(self._number, self._rotation, self._most_moved)
        self._moved = float(np.linalg.norm(self._inwards))
        self._watch_place()
        self._looking_since: TaskTime | None = None

    def _watch_place(self) -> None:
        self._watch = SurfaceWatch(self.context, self._radius, reach_down(self.context))
        self._aim()

    def _aim(self) -> None:
        """Take the place where it is by the newest estimate of the map, off a seen edge."""
        slot = self._places.centre(self._number or 1) + self._inwards
        self._watch.aim(slot)
        up = self._watch.higher + release_height(self.context)
        self._down = SE3(self._rotation, slot + np.array([0.0, 0.0, up]))

    @property
    def _above(self) -> SE3:
        """Where the hand comes from and goes back to."""
        out = _BARELY if self._is_below else self._up * way_out(self._rotation)
        return SE3(self._rotation, self._down.translation + out)

    def _begin(self) -> Status:
        """Set out, if there is an object and a place for it."""
        if self._number is None:
            return self.failure(self._places.none_free())
        if reason := self.empty_hand or ("" if self.context.log.in_hand else "nothing was grasped"):
            return self.failure(f"nothing to place: {reason}")
        self._set_out()
        return self._approach()

    def _look(self) -> str | None:
        """Look at the place; returns why nothing can be placed, if so."""
        look = self._watch.look()
        if look.edge is not None and (short := self._too_near(look.edge)) > 0.0:
            by = short + _OFF_EDGE
            if self._moved + by <= self._most_moved:
                self._say(f"{self._place} is at an edge: moved by {1000 * by:.0f} mm")
                self._move_place(by * look.edge.inwards)
                return None
            if look.shows is Shows.LOWER and look.edge.distance > -self._radius:
                self._say(f"{self._place} is at an edge: passed over")
                return self._pass_over()
        if look.shows is Shows.LOWER:
            return f"no surface at {self._place}: it is {-look.height:.2f} m lower"
        return self._pass_over() if look.shows is Shows.HIGHER else None

    def _too_near(self, edge: Edge) -> float:
        """How much nearer to an edge the place is than the held object may be [m]."""
        outwards = -self._rotation.T @ edge.inwards
        return reach_on_surface(self.context.held, outwards) - edge.distance

    def _say(self, text: str) -> None:
        self.context.log.say(self.context.clock.now(), text)

    def _move_place(self, by: Array) -> None:
        """Move the place by (3,) in the world [m], and go over it."""
        self._inwards, self._moved = self._inwards + by, self._moved + float(np.linalg.norm(by))
        self._watch_place()
        self._set_out()

    def _pass_over(self) -> str | None:
        """Choose another place; returns why not, if so."""
        self._places.pass_over(self._number)
        self._choose()
        self._set_out()
        return self._places.none_free() if self._number is None else None

    def _approach(self) -> Status:
        self._aim()
        speed, tolerance = _APPROACH_SPEED, _APPROACH_TOLERANCE
        return self._move("over the place", self._above, speed, tolerance, self._arrive)

    def _set_out(self) -> None:
        """Go over the place: straight, or the base to another stance first."""
        self._step = self._approach
        self._progress = Progress(self.context, straight=self._goes_straight)

    def _less_high_or_elsewhere(self, report: StepReport) -> Status:
        """Come from less high if that is out of reach; else go to another place."""
        if report.unreachable and self._up > _LEAST_ABOVE:
            self._up = _LEAST_ABOVE
        else:
            away = f"over the place: stuck {report.position_error:.2f} m away"
            if not report.unreachable:
                self._note(self.context.log.places_blocked)
                self._stuck += 1
            if self._stuck > _MOST_STUCK or self._pass_over():
                return self.failure(away + self._progress.because)
        self._set_out()
        return self.running(f"going to {self._place}")

    def _arrive(self) -> Status:
        """Go down if the surface was seen on the way, else look for it."""
        self._progress = Progress(self.context)
        if self._watch.has_seen_surface:
            self._step = self._lower
            return self._lower()
        if self._looking_since is None:
            self._looking_since = self.context.clock.now()
        self._step = self._give_way
        return self.running("looking at the place")

    def _give_way(self) -> Status:
        """Move the held object, which may hide the place, out of the view, and come back."""
        context, since = self.context, self._looking_since
        if self._watch.has_seen_surface:
            self._set_out()
            return self._approach()
        if since is not None and context.clock.now() - since > CAMERA_PATIENCE:
            reason = context.vision.blindness(context.state.stamp)
            here, self._unseen = self._place, self._unseen + 1
            if not reason:
                self._note(self.context.log.places_unseen)
            if reason or self._unseen > _MOST_UNSEEN or self._pass_over():
                return self.failure(reason or f"{here} is not seen")
            return self.running(f"{here} is not seen, going to {self._place}")
        aside = out_of_view(self._above, context.robot.description.camera.eTc)
        goal = PoseGoal(wTe=aside, speed=_APPROACH_SPEED, straight=True)
        self.pursue(goal, "looking at the place")
        return self.running("looking at the place")

    def _lower(self) -> Status:
        if self.context.relocalised:
            return self._go_back()
        return self._move("lowering", self._down, _LOWER_SPEED, _LOWER_TOLERANCE, self._release)

    def _go_back(self) -> Status:
        """Go over the place again after a relocalisation."""
        self._relocalised += 1
        if self._relocalised > _MOST_RELOCALISATIONS:
            return self.failure(self.context.relocalised)
        self._set_out()
        return self._approach()

    def _release(self) -> Status:
        watch = self._watch
        self._releasing = Release(
            self,
            self._goal,
            spot=Spot(self._place, watch.centre, self._radius, watch.heights),
            up=self._up,
            backs_off=self._is_high,
            used=lambda: self._note(self.context.log.places_used),
        )
        self._step = self._let_go
        return self.running("letting go")

    def _let_go(self) -> Status:
        status = self._releasing.tick()
        if status is Status.SUCCESS:
            self.feedback_message = f"placed on {self._on.name}, {self._places.name(self._number)}"
        return status

    @property
    def _place(self) -> str:
        return f"{self._places.name(self._number)} of {self._on.name}"

    def _block(self) -> None:
        """Remember a place at which lowering failed."""
        if self._step == self._lower:
            self._note(self.context.log.places_blocked)

    def _note(self, places: dict[str, set[int]]) -> None:
        if self._number is not None:
            places.setdefault(self._on.name, set()).add(self._number)

    def _move(
        self, what: str, wTe: SE3, speed: float, tolerance: float, then: Callable[[], Status]
    ) -> Status:
        """One tick of a straight motion of the hand, then the next phase."""
        if reason := self.empty_hand:
            if self._step == self._lower and self.fingers_have_opened:
                return self._release()  # it stands already, and turns in the fingers
            return self.failure(f"nothing left to place: {reason}")
        self._goal = PoseGoal(
            wTe=wTe,
            speed=speed,
            position_tolerance=tolerance,
            orientation_tolerance=TILT,
            straight=self._step != self._approach or self._goes_straight,
            stance_if_near=True,
            hand_may_touch=self._step == self._lower,
        )
        report = self.pursue(self._goal, f"{what} {self._number} from {self._up:.2f} m")
        if report is None:
            return self.running(what)
        if report.arrived:
            self._step, self._progress = then, Progress(self.context, straight=True)
            return then()
        if not self._progress.is_stuck(report):
            return self.running(f"{what}, {report.position_error:.2f} m to go")
        if self._step == self._approach and self._goes_straight:
            self._goes_straight = False
            self._set_out()
            return self.running(f"{what}, from another stance")
        if self._step == self._approach:
            return self._less_high_or_elsewhere(report)
        self._block()
        away = f"{what}: stuck {report.position_error:.2f} m away"
        return self.failure(away + self._progress.because)
