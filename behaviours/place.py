"""Behaviour `place`: set the held object down in a region, at a pose, or onto an object."""

from math import pi, radians
from typing import Annotated, ClassVar

import numpy as np
from pinocchio import SE3
from py_trees.common import Status

from behaviours.core.arguments import validate_place
from behaviours.core.context import Context
from behaviours.core.directions import Direction, points_down, upright
from behaviours.core.held_object import reach_on_surface
from behaviours.core.parameter_types import Bounds, Deviation, Pitch, Region, ToolPose
from behaviours.core.reachable_directions import room_above
from behaviours.exact_place import (
    LookAtPlace,
    Measurement,
    aligned,
    region_around,
    region_at,
    region_on,
)
from behaviours.lowering import ABOVE, Lowering
from behaviours.places import Places
from behaviours.release import reach_down, release_height
from behaviours.views.surface import Edge, Shows, SurfaceWatch
from config.arrays import Array
from perception import DetectedObject

_BOARD = 0.5  # what is nearer above is a board, below which the hand comes in [m]
_RADIUS = 0.06  # of the disc around the place that has to be free [m] ...
_PITCH_SHARE = 0.45  # ... and most of the distance between places, by which one is moved, too
_OFF_EDGE = 0.005  # by which a place that is too near to an edge is moved farther [m]
_FALLEN = 0.01  # what reaches less high than the hand held it has fallen off, if by more [m]


class Place(Lowering):
    """Set the held object down, on a free place of a region or exactly there.

    The camera has to see nearly all of the floor at the place before the hand is lowered. A place
    at a seen edge is moved off it, and passed over if that is too far; so is one on which something
    stands, or that is not seen. Rows far from the base are filled first, near ones if a hand that
    points down works above the shoulder. What a tilted hand gripped is set down with that tilt;
    below a board the base carries it in. The hand stops as high above the floor as it was above
    what the object stood on, by the camera where the map is wrong, and a little higher. A place at
    which lowering failed is not tried again, one that was not seen only after the others. Exactly
    there means the middle of the object, as it was seen before the fingers closed, and its longer
    edge; no other place is tried. Fails when nothing is held, no place is free, seen or reached,
    the fingers do not open, the object is not seen to stand, or on a fault.

    Args:
        on: region of the task file whose floor is the surface to place on.
        at: a tool pose as a point of a surface: there its middle comes to stand, its longer edge
            along the x axis.
        onto: stack it on an object that `detect` found, or on what stands nearest to the middle of
            a region.
        pitch_m: distance between neighbouring places; half of it when the rows are full [m].
        within_m: fail if it is seen to stand farther from there [m].
        within_deg: fail if it is longer than wide, and turned from `at` by more [deg].
    """

    key: ClassVar[str] = "place"
    hand_before: ClassVar[str] = "full"
    hand_after: ClassVar[str] = "empty"
    surfaces: ClassVar[tuple[str, ...]] = ("on", "at", "onto")
    validate = staticmethod(validate_place)

    def __init__(
        self,
        name: str,
        context: Context,
        *,
        on: Region | None = None,
        at: ToolPose | None = None,
        onto: Region | DetectedObject | None = None,
        pitch_m: Pitch = 0.2,
        within_m: Annotated[float, Bounds(least=0.002, most=0.5)] = 0.02,
        within_deg: Deviation = 10.0,
    ) -> None:
        super().__init__(name, context)
        self._onto, self._pitch, self._is_exact = onto, pitch_m, on is None
        self._within = within_m, pi if at is None else radians(within_deg)
        if region := region_at(at) if at is not None else on:
            self._place_on(region, context.direction(region))
        elif isinstance(onto, Region):
            self._way_in = context.direction(onto)

    def _place_on(self, on: Region, way_in: Direction) -> None:
        context, self._on, self._way_in = self.context, on, way_in
        robot = context.robot.description
        shoulder = float((robot.bTa * robot.arm.joints[0]).translation[2])
        self._is_above_shoulder = on.floor > shoulder
        self._is_below = room_above(on, context.around.fixtures) < _BOARD
        self._goes_straight = not self._is_below
        self._places = Places(context, on, self._pitch)
        self._most_moved = 0.0 if self._is_exact else _PITCH_SHARE * min(self._pitch, *on.size[:2])
        self._radius = min(_RADIUS, _PITCH_SHARE * min(self._pitch, *on.size[:2]))

    def initialise(self) -> None:
        """Choose the place."""
        context, self._step = self.context, self._begin
        self._begin_anew()
        if (onto := self._onto) is None:
            return self._plan()
        if isinstance(onto, DetectedObject):
            self._way_in = context.direction_now(onto).turned(context.to_map(SE3.Identity()))
            onto = region_around(context, onto)
        self._survey = LookAtPlace(self, onto, self._way_in.turned(onto.oTm))
        self._step = self._look_below

    def _look_below(self) -> Status:
        """Find what it is to stand on."""
        if reason := self._nothing_held:
            return self.failure(reason)
        found = self._survey.tick()
        if found is Status.FAILURE:
            return self.failure(f"nothing is seen to stack it on: {self.feedback_message}")
        if isinstance(found, Status):
            return found
        if not found:
            return self.failure("nothing stands there to stack it on")
        self._place_on(region_on(self.context, self._survey.nearest(found)), self._way_in)
        self._plan()
        self._step = self._begin
        return self._begin()

    def _plan(self) -> None:
        context = self.context
        now, way_in = context.oTe.rotation, self._way_in.turned(self._on.oTm)
        self._rotation, self._to_hand = upright(context.log.last_grasp, now, way_in), np.zeros(3)
        self._is_high = self._is_above_shoulder and points_down(self._rotation)
        self._places.begin(far_first=not self._is_high)
        if self._is_exact:
            self._rotation, self._to_hand = aligned(context, self._rotation, self._on)
            for places in (context.log.places_used, context.log.places_blocked):
                places.pop(self._on.name, None)  # the camera says what stands there
        self._choose()

    def _choose(self) -> None:
        """Aim at the next free place, moved off what was set down beside it."""
        self._number = self._places.next_free()
        self._up = ABOVE
        self._inwards = self._places.beside(self._number, self._rotation, self._most_moved)
        self._moved = float(np.linalg.norm(self._inwards))
        self._watch_place()
        self._looking_since = None

    def _watch_place(self) -> None:
        self._watch = SurfaceWatch(self.context, self._radius, reach_down(self.context))
        self._aim()

    def _aim(self) -> None:
        """Take the place where it is by the newest estimate of the map, off a seen edge."""
        slot = self._places.centre(self._number or 1) + self._inwards
        self._watch.aim(slot)
        up = self._watch.higher + release_height(self.context)
        self._down = SE3(self._rotation, slot + self._to_hand + np.array([0.0, 0.0, up]))

    def _begin(self) -> Status:
        """Set out, if there is an object and a place for it."""
        if self._number is None:
            return self.failure(self._none_free)
        if reason := self._nothing_held:
            return self.failure(reason)
        self._set_out()
        return self._approach()

    @property
    def _nothing_held(self) -> str:
        reason = self.empty_hand or ("" if self.context.log.in_hand else "nothing was grasped")
        return reason and f"nothing to place: {reason}"

    @property
    def _none_free(self) -> str:
        return f"{self._on.name} is taken" if self._is_exact else self._places.none_free()

    def _look(self) -> str | None:
        """Look at the place; returns why nothing can be placed, if so."""
        look = self._watch.look()
        edge = None if self._is_exact else look.edge
        if edge is not None and (short := self._too_near(edge)) > 0.0:
            by = short + _OFF_EDGE
            if self._moved + by <= self._most_moved:
                self._say(f"{self._place} is at an edge: moved by {1000 * by:.0f} mm")
                self._move_place(by * edge.inwards)
                return None
            if look.shows is Shows.LOWER and edge.distance > -self._radius:
                self._say(f"{self._place} is at an edge: passed over")
                return self._pass_over()
        if look.shows is Shows.LOWER:
            return f"no surface at {self._place}: it is {-look.height:.2f} m lower"
        return self._pass_over() if look.shows is Shows.HIGHER else None

    def _too_near(self, edge: Edge) -> float:
        """How much nearer to an edge the place is than the held object may be [m]."""
        outwards = -self._rotation.T @ edge.inwards
        return reach_on_surface(self.context.memory.held, outwards) - edge.distance

    def _say(self, text: str) -> None:
        self.context.log.say(self.context.clock.now(), text)

    def _move_place(self, by: Array) -> None:
        """Move the place by (3,) in odometry [m], and go over it."""
        self._inwards, self._moved = self._inwards + by, self._moved + float(np.linalg.norm(by))
        self._watch_place()
        self._set_out()

    def _pass_over(self) -> str | None:
        """Choose another place; returns why not, if so."""
        self._places.pass_over(self._number)
        self._choose()
        self._set_out()
        return self._none_free if self._number is None else None

    def _let_go(self) -> Status:
        status = self._releasing.tick()
        if status is not Status.SUCCESS:
            return status
        if not self._is_exact:
            return self.success(f"placed on {self._on.name}{self._numbered}")
        within, turn, log = *self._within, self.context.log
        is_known = self._onto is not None and log.grip_outline is not None
        self._measured = Measurement(
            self,
            self._on,
            self._way_in.turned(self._on.oTm),
            within=within,
            turn=turn,
            least=log.grip_height - _FALLEN if is_known else 0.0,
        )
        self._step = self._measured.judge
        return self.running("measuring where it stands")

    @property
    def _numbered(self) -> str:
        return "" if self._is_exact else f", {self._places.name(self._number)}"

    @property
    def _place(self) -> str:
        number = "" if self._is_exact else f"{self._places.name(self._number)} of "
        return f"{number}{self._on.name}"
