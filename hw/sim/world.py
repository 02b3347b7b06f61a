"""Everything around the simulated robot: what stands fast, what moves or can be moved."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from hw.sim.contact import TOUCH, Vicinity, separation, travel
from hw.sim.grasp_contact import Reason, squeeze
from hw.sim.hand import CENTRE, RADIUS, hand_shapes
from hw.sim.sim_object import SimObject
from robots.shapes import Geom

HAND_TOLERANCE = 0.002
"""The hand may press into things this deep before it counts as a collision [m] ..."""

HELD_TOLERANCE = 0.005
"""... and a held object, which yields in the fingers, this deep [m]."""

_DOWN = np.array([0.0, 0.0, -1.0])
_MAX_FALL = 3.0
_LIFT_STEP = 0.005
_MAX_LIFTS = 60
_RESTING_GAP = 0.0015


@dataclass(frozen=True, kw_only=True)
class GraspOutcome:
    """What closing the fingers led to."""

    holding: str | None
    """Name of the object that is held now."""
    width: float
    """Distance between the pads where they came to rest [m]."""
    reason: Reason
    """Held, or why not; `reason.value` is for people."""
    touched: str | None = None
    """Name of the object that the pads pressed on, held or not."""


class World:
    """Fixtures and objects, and what the hand does to them.

    Args:
        fixtures: what never moves, in the world; the part of a name before `/` is its group.
        objects: what can be picked up, each at its pose.
    """

    def __init__(self, fixtures: Sequence[Geom], objects: Sequence[SimObject]) -> None:
        self.fixtures = tuple(fixtures)
        self.objects = list(objects)
        self.held: SimObject | None = None
        self._eTo = SE3.Identity()
        self._held_width = 0.0
        self._vicinity = Vicinity(self.fixtures)

    def shapes(self) -> list[Geom]:
        """Everything that can be seen but the robot, in the world."""
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
        """Bring everything that moves by itself to where it is at a time [s]."""
        for thing in self.objects:
            if thing.motion is not None:
                thing.pose = SE3(thing.pose.rotation, thing.motion.position(now))

    def close_fingers(
        self, wTe: SE3, width_before: float, force: float, width: float = 0.0
    ) -> GraspOutcome:
        """Close the fingers on whatever is between them, and hold it if they can.

        An object that is pressed on but not held comes to rest where the pads dragged it.

        Args:
            wTe: end effector in the world.
            width_before: distance between the pads before [m].
            force: of each finger [N].
            width: where the fingers stop unless something stops them before [m].
        """
        if self.held is not None:
            name = self.held.name
            return GraspOutcome(
                holding=name, width=self._held_width, reason=Reason.HELD, touched=name
            )
        centre = wTe.act(CENTRE)
        fixtures = self._vicinity.near(centre, RADIUS)
        result = squeeze(wTe, width_before, force, self._objects_near(wTe), fixtures)
        if result.width <= width:
            return GraspOutcome(holding=None, width=width, reason=Reason.NOTHING)
        touched = result.object
        if touched is not None and result.wTo is not None:
            touched.pose, touched.motion = result.wTo, None
            if result.reason is Reason.HELD:
                self.held, self._held_width = touched, result.width
                self._eTo = wTe.actInv(result.wTo)
            else:
                self._drop(touched)
        return GraspOutcome(
            holding=None if self.held is None else self.held.name,
            width=result.width,
            reason=result.reason,
            touched=None if touched is None else touched.name,
        )

    def open_fingers(self) -> None:
        """Let go: the held object falls straight down onto whatever is below it."""
        if self.held is not None:
            dropped, self.held = self.held, None
            self._drop(dropped)

    def carry(self, wTe: SE3) -> None:
        """Move the held object along with the end effector."""
        if self.held is not None:
            self.held.pose = wTe * self._eTo

    def collision(self, wTe: SE3, width: float) -> str | None:
        """Name of something that the hand, or what it holds, presses into too deeply.

        The held object may touch other objects, as when it is stood on them.

        Args:
            wTe: end effector in the world.
            width: distance between the pads [m].
        """
        centre = wTe.act(CENTRE)
        nearby = self._vicinity.near(centre, RADIUS)
        nearby += [part for o in self._objects_near(wTe) for part in o.placed()]
        if nearby and (hit := _deepest(hand_shapes(wTe, width), nearby, HAND_TOLERANCE)):
            return hit
        if self.held is not None:
            around = self._vicinity.near(self.held.pose.translation, self.held.radius)
            return _deepest(self.held.placed(), around, HELD_TOLERANCE)
        return None

    def resting_on(self, thing: SimObject) -> str:
        """Group of the fixtures that carry an object, directly or through other objects.

        Returns:
            For example `container` or `table`; `hand` when held, empty when nothing carries it.
        """
        return self._support(thing, frozenset())

    def supports(self) -> dict[str, str]:
        """What carries each object, by its name, as `resting_on` tells."""
        return {thing.name: self.resting_on(thing) for thing in self.objects}

    def _support(self, thing: SimObject, visited: frozenset[str]) -> str:
        if thing is self.held:
            return "hand"
        parts = [part.moved(SE3(np.eye(3), _RESTING_GAP * _DOWN)) for part in thing.placed()]
        around = self._vicinity.near(thing.pose.translation, thing.radius + _RESTING_GAP)
        for fixture in around:
            if any(_presses_down(part, fixture) for part in parts):
                return fixture.name.split("/")[0]
        for other in self._others_below(thing, _RESTING_GAP):
            touching = any(_presses_down(a, b) for a in parts for b in other.placed())
            if touching and other.name not in visited:
                found = self._support(other, visited | {thing.name})
                if found:
                    return found
        return ""

    def _drop(self, thing: SimObject) -> None:
        """Fall to the first contact, from the lowest free place at or above where it is."""
        below = [
            *self.fixtures,
            *(part for o in self._others_below(thing, _MAX_FALL) for part in o.placed()),
        ]
        for _ in range(_MAX_LIFTS):
            if not any(_overlapping(a, b) for a in thing.placed() for b in below):
                break
            thing.pose = _raised(thing.pose, _LIFT_STEP)
        falls = [travel(part, _DOWN, below, _MAX_FALL) for part in thing.placed()]
        fall = min((f for f in falls if f is not None), default=0.0)
        thing.pose = _raised(thing.pose, -fall)

    def _others_below(self, thing: SimObject, depth: float) -> Iterable[SimObject]:
        """Objects that may be in the way of one that falls by `depth` [m], or rises."""
        x, y, z = thing.pose.translation
        for other in self.objects:
            if other is thing or other is self.held:
                continue
            ox, oy, oz = other.pose.translation
            reach = other.radius + thing.radius
            if np.hypot(ox - x, oy - y) < reach and oz < z + reach + depth:
                yield other

    def _objects_near(self, wTe: SE3) -> list[SimObject]:
        """Objects within reach of the hand, but for the held one."""
        centre = wTe.act(CENTRE)
        return [
            o
            for o in self.objects
            if o is not self.held
            and np.linalg.norm(o.pose.translation - centre) < RADIUS + o.radius
        ]


def _deepest(shapes: Iterable[Geom], others: Sequence[Geom], tolerance: float) -> str | None:
    """Name of whichever of the others is pressed into deepest, if deeper than the tolerance [m]."""
    worst, name = -tolerance, None
    for shape in shapes:
        for other in others:
            gap, _ = separation(shape, other)
            if gap < worst:
                worst, name = gap, other.name
    return name


def _overlapping(a: Geom, b: Geom) -> bool:
    """Whether a shape is inside another, beyond what a touch from the side excuses."""
    gap, normal = separation(a, b)
    return gap < -HELD_TOLERANCE or (gap < -TOUCH and abs(normal[2]) > 0.5)


def _presses_down(a: Geom, b: Geom) -> bool:
    gap, normal = separation(a, b)
    return gap < 0.0 and normal[2] < -0.3


def _raised(pose: SE3, height: float) -> SE3:
    return SE3(pose.rotation, pose.translation - height * _DOWN)
