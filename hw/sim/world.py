"""The world around the simulated robot: fixtures, and objects that move or can be moved."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from hw.sim.contact import TOUCH, Vicinity, separation, travel
from hw.sim.grasp_contact import Reason, grasp_contact
from hw.sim.hand import Hand
from hw.sim.sim_object import SimObject
from robots import Geom

HAND_TOLERANCE = 0.002
"""Depth to which the hand may press into something before it counts as a collision [m]."""

HELD_TOLERANCE = 0.005
"""The same for a held object, which yields in the fingers [m]."""

_DOWN = np.array([0.0, 0.0, -1.0])
_MAX_FALL = 3.0
_LIFT_STEP = 0.005
_MAX_LIFTS = 60
_RESTING_GAP = 0.0015


@dataclass(frozen=True, kw_only=True)
class GraspOutcome:
    """What closing the fingers led to."""

    holding: str | None
    """Name of the object that is held now; None if the hand is empty."""
    width: float
    """Distance between the pads where they came to rest [m]."""
    reason: Reason
    """Held, or why not; `reason.value` is for people."""
    touched: str | None = None
    """Name of the object that the pads pressed on, held or not."""


class World:
    """Fixtures and objects, and the effects of the hand on them.

    Args:
        fixtures: shapes that never move, in the world; the part of a name before `/` is its group.
        objects: objects that can be picked up, each at its pose.
    """

    def __init__(self, fixtures: Sequence[Geom], objects: Sequence[SimObject]) -> None:
        self.fixtures = tuple(fixtures)
        self.objects = list(objects)
        self.held: SimObject | None = None
        self._eTo = SE3.Identity()
        self._held_width = 0.0
        self._vicinity = Vicinity(self.fixtures)

    def shapes(self) -> list[Geom]:
        """All visible shapes but those of the robot, in the world."""
        return [*self.fixtures, *(part for o in self.objects for part in o.placed())]

    def find(self, name: str) -> SimObject:
        """The object of that name.

        Raises:
            KeyError: there is none.
        """
        for candidate in self.objects:
            if candidate.name == name:
                return candidate
        raise KeyError(f"no object {name!r}; there are {[o.name for o in self.objects]}")

    def move_to(self, now: float) -> None:
        """Move the objects that move by themselves to their positions at a time [s]."""
        for obj in self.objects:
            if obj.motion is not None:
                obj.pose = SE3(obj.pose.rotation, obj.motion.position(now))

    def close_fingers(
        self, hand: Hand, width_before: float, force: float, width: float = 0.0
    ) -> GraspOutcome:
        """Close the fingers, and hold the object between them if the contacts allow it.

        An object that is pressed on but not held comes to rest where the pads dragged it.

        Args:
            hand: the gripper and where it is.
            width_before: distance between the pads before [m].
            force: of each finger [N].
            width: where the fingers stop if nothing stops them before [m].
        """
        if self.held is not None:
            name = self.held.name
            return GraspOutcome(
                holding=name, width=self._held_width, reason=Reason.HELD, touched=name
            )
        fixtures = self._vicinity.near(hand.centre, hand.radius)
        result = grasp_contact(hand, width_before, force, self._objects_near(hand), fixtures)
        if result.width <= width:
            return GraspOutcome(holding=None, width=width, reason=Reason.NOTHING)
        touched = result.object
        if touched is not None and result.wTo is not None:
            touched.pose, touched.motion = result.wTo, None
            if result.reason is Reason.HELD:
                self.held, self._held_width = touched, result.width
                self._eTo = hand.wTe.actInv(result.wTo)
            else:
                self._drop(touched)
        return GraspOutcome(
            holding=None if self.held is None else self.held.name,
            width=result.width,
            reason=result.reason,
            touched=None if touched is None else touched.name,
        )

    def open_fingers(self) -> None:
        """Let go: the held object falls straight down onto what is below it."""
        if self.held is not None:
            dropped, self.held = self.held, None
            self._drop(dropped)

    def put(self, name: str, wTo: SE3) -> None:
        """Put an object somewhere, out of the hand if it is held; it falls onto what is below.

        Args:
            name: of the object.
            wTo: from where it falls.

        Raises:
            KeyError: there is no such object.
        """
        obj = self.find(name)
        if obj is self.held:
            self.held = None
        obj.pose, obj.motion = wTo, None
        self._drop(obj)

    def carry(self, wTe: SE3) -> None:
        """Move the held object along with the end effector."""
        if self.held is not None:
            self.held.pose = wTe * self._eTo

    def collision(self, hand: Hand, width: float) -> str | None:
        """Name of a shape that the hand or the held object presses into too deeply, if any.

        The held object may touch other objects, as when it is placed on them.

        Args:
            hand: the gripper and where it is.
            width: distance between the pads [m].
        """
        nearby = self._vicinity.near(hand.centre, hand.radius)
        nearby += [part for o in self._objects_near(hand) for part in o.placed()]
        if nearby and (hit := _deepest(hand.shapes(width), nearby, HAND_TOLERANCE)):
            return hit
        if self.held is not None:
            around = self._vicinity.near(self.held.pose.translation, self.held.radius)
            return _deepest(self.held.placed(), around, HELD_TOLERANCE)
        return None

    def resting_on(self, obj: SimObject) -> str:
        """Group of the fixture that carries an object, directly or through other objects.

        Returns:
            For example `container` or `table`; `hand` if held, empty if nothing carries it.
        """
        return self._support(obj, frozenset())

    def supports(self) -> dict[str, str]:
        """What each object rests on, by its name; see `resting_on`."""
        return {obj.name: self.resting_on(obj) for obj in self.objects}

    def _support(self, obj: SimObject, visited: frozenset[str]) -> str:
        if obj is self.held:
            return "hand"
        parts = [part.moved(SE3(np.eye(3), _RESTING_GAP * _DOWN)) for part in obj.placed()]
        around = self._vicinity.near(obj.pose.translation, obj.radius + _RESTING_GAP)
        for fixture in around:
            if any(_presses_down(part, fixture) for part in parts):
                return fixture.name.split("/")[0]
        for other in self._others_below(obj, _RESTING_GAP):
            touching = any(_presses_down(a, b) for a in parts for b in other.placed())
            if touching and other.name not in visited:
                found = self._support(other, visited | {obj.name})
                if found:
                    return found
        return ""

    def _drop(self, obj: SimObject) -> None:
        """Let an object fall to its first contact, lifted until it is free."""
        below = [
            *self.fixtures,
            *(part for o in self._others_below(obj, _MAX_FALL) for part in o.placed()),
        ]
        for _ in range(_MAX_LIFTS):
            if not any(_overlapping(a, b) for a in obj.placed() for b in below):
                break
            obj.pose = _raised(obj.pose, _LIFT_STEP)
        falls = [travel(part, _DOWN, below, _MAX_FALL) for part in obj.placed()]
        fall = min((f for f in falls if f is not None), default=0.0)
        obj.pose = _raised(obj.pose, -fall)

    def _others_below(self, obj: SimObject, depth: float) -> Iterable[SimObject]:
        """Objects that another may meet while it falls by `depth` [m], or rises."""
        x, y, z = obj.pose.translation
        for other in self.objects:
            if other is obj or other is self.held:
                continue
            ox, oy, oz = other.pose.translation
            reach = other.radius + obj.radius
            if np.hypot(ox - x, oy - y) < reach and oz < z + reach + depth:
                yield other

    def _objects_near(self, hand: Hand) -> list[SimObject]:
        """Objects near the hand, without the held one."""
        centre, radius = hand.centre, hand.radius
        return [
            o
            for o in self.objects
            if o is not self.held
            and np.linalg.norm(o.pose.translation - centre) < radius + o.radius
        ]


def _deepest(shapes: Iterable[Geom], others: Sequence[Geom], tolerance: float) -> str | None:
    """Name of the shape that is pressed into deepest, if deeper than a tolerance [m]."""
    worst, name = -tolerance, None
    for shape in shapes:
        for other in others:
            gap, _ = separation(shape, other)
            if gap < worst:
                worst, name = gap, other.name
    return name


def _overlapping(a: Geom, b: Geom) -> bool:
    """Whether two shapes overlap by more than a touch from the side."""
    gap, normal = separation(a, b)
    return gap < -HELD_TOLERANCE or (gap < -TOUCH and abs(normal[2]) > 0.5)


def _presses_down(a: Geom, b: Geom) -> bool:
    gap, normal = separation(a, b)
    return gap < 0.0 and normal[2] < -0.3


def _raised(pose: SE3, height: float) -> SE3:
    return SE3(pose.rotation, pose.translation - height * _DOWN)
