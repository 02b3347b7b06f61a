"""What has stopped the robot: where, how often, when it is cleared again, and the way from it."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, sin

import numpy as np
from pinocchio import SE3

from behaviours.settings import RecoverSettings
from controller import Array, Obstacle
from hw import Fault, FaultKind, RobotState, TaskTime
from robots import Box, Cylinder, Geom, RobotDescription, half_extents

_STEP = 0.01
"""Base and hand are noted down every time they have come this far [m]."""
_STEPS = 60
"""So many places of theirs are kept."""
_NEAR_MOVER = 0.2
"""What moves by itself and is nearer than this to a contact is what was hit [m]."""
_WHAT = "what was hit"
"""Name of what stands at a contact."""


@dataclass(eq=False)
class _Place:
    """Where faults of one kind came; those that are no contacts have no place."""

    kind: FaultKind
    point: Array | None
    """(3,) in the world [m]."""
    last: TaskTime
    times: int = 0
    shapes: tuple[Geom, ...] = ()
    """What stands there, in the world."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WayOut:
    """How to get away from what was hit."""

    base: Array | None
    """(2,) unit vector in the base frame; None if the base was not touched."""
    hand: SE3 | None
    """Where the hand came from, in the world; None if the arm was not touched."""


class FaultMemory:
    """Notes every fault of a run, whichever leaf clears it, and says when that may be.

    A contact is one of base (bumper) or arm (reflex). Where it was, something stands from then on:
    an upright cylinder beside the base, a small box at the hand. That is so unless something that
    is known to move was there, or the hand was at work, among what it may touch. It is gone when
    the base is relocalised; count and all are forgotten after a time, and where a person
    acknowledges.

    Args:
        robot: its description.
        settings: times, distances and numbers.
    """

    def __init__(self, robot: RobotDescription, settings: RecoverSettings) -> None:
        self._robot = robot
        self._settings = settings
        self._places: list[_Place] = []
        self._present: set[FaultKind] = set()
        """Of the faults that are there now."""
        self._since: TaskTime | None = None
        self._cleared: list[TaskTime] = []
        self._is_tried = False
        """Whether the faults that are there now, or were last, have been cleared."""
        self._bases: deque[SE3] = deque(maxlen=_STEPS)
        self._hands: deque[SE3] = deque(maxlen=_STEPS)
        self._way_out: tuple[WayOut, SE3] | None = None
        self.given_up = ""
        """What has come back too often, for people; empty as long as a program may clear it."""
        self.hit: tuple[Geom, ...] = ()
        """What was hit, in the world; the same object as long as nothing has changed."""

    def note(
        self,
        state: RobotState,
        wTe: SE3,
        now: TaskTime,
        moving: Sequence[Obstacle] = (),
        *,
        at_work: bool = False,
    ) -> None:
        """Take a reading.

        Args:
            state: the reading.
            wTe: of the end effector then.
            now: the task's time.
            moving: what is known to move by itself.
            at_work: whether the hand was to go among what it may touch.
        """
        kept = [one for one in self._places if now.since(one.last) < self._settings.remembered]
        if len(kept) < len(self._places):
            self._keep(kept)
        if not state.faults:
            self._since = None
            self._present.clear()
            _trace(self._bases, state.wTb)
            _trace(self._hands, wTe)
            return
        if state.recovering:
            self._cleared[-1:] = [now]  # what counts is when that has ended
            return
        if is_again := self._is_tried:
            self._since, self._is_tried = None, False
            self._present.clear()
        self._since = self._since or now
        for fault in state.faults:
            if fault.clearable and fault.kind not in self._present:
                where, radius, shape = self._contact(fault, state, wTe)
                touched = where if shape is None else shape.pose.translation
                if any(_is_near(one.geom, touched) for one in moving):
                    shape = None  # who tells of it tells where it is now
                elif at_work and fault.kind is FaultKind.REFLEX:
                    shape = None
                self._count(fault, now, where, radius, shape, is_again=is_again)

    def wait(self, now: TaskTime) -> float:
        """How long to wait until the faults that are there may be cleared [s]."""
        pauses, since = self._settings.pauses, self._since or now
        self._cleared = [one for one in self._cleared if now.since(one) < self._settings.lately]
        wait = pauses[0] - now.since(since)
        if self._cleared:
            pause = pauses[min(len(self._cleared), len(pauses) - 1)]
            wait = max(wait, pause - now.since(self._cleared[-1]))
        return max(0.0, wait)

    def clear(self, now: TaskTime) -> None:
        """The faults that are there are being cleared."""
        self._cleared.append(now)
        self._is_tried = True

    def acknowledge(self) -> None:
        """A person has seen to what came back too often."""
        self.given_up = ""
        self._is_tried, self._cleared = True, []
        self._keep([])

    def relocalise(self) -> None:
        """Nothing stands where it was; how often something was hit is not forgotten."""
        for place in self._places:
            place.shapes = ()
        self._keep(self._places)
        self._bases.clear()
        self._hands.clear()
        if self._way_out is not None:
            way, wTb = self._way_out
            self._way_out = WayOut(base=way.base, hand=None), wTb

    def take_way_out(self, wTb: SE3) -> WayOut | None:
        """The way from the last contact, once; None if the base, now at wTb, has left it."""
        found, self._way_out = self._way_out, None
        if found is None:
            return None
        way, wTb_then = found
        gone = np.linalg.norm(wTb.translation - wTb_then.translation)
        return way if gone < self._settings.same_place else None

    def _contact(
        self, fault: Fault, state: RobotState, wTe: SE3
    ) -> tuple[Array | None, float, Geom | None]:
        """Where base or hand were (3,), how far from there is the same place [m], what was hit.

        A contact has a way out besides. The base may turn between two contacts, or touch something
        behind it on its way out: what counts is where it was.
        """
        settings, wTb = self._settings, state.wTb
        before = WayOut(base=None, hand=None) if self._way_out is None else self._way_out[0]
        if fault.kind is FaultKind.BUMPER:
            away = self._away(fault.bearing, wTb)
            side = atan2(-away[1], -away[0]) if fault.bearing is None else fault.bearing
            cylinder = self._beside_base(side, wTb)
            self._way_out = WayOut(base=away, hand=before.hand), wTb
            return wTb.translation, settings.same_place, cylinder
        if fault.kind is FaultKind.REFLEX:
            back = _back(self._hands, wTe, settings.way_back)
            self._way_out = WayOut(base=before.base, hand=wTe if back is None else back), wTb
            here = wTe.translation
            box = Geom(Box((settings.hit_half,) * 3), SE3(np.eye(3), here), _WHAT)
            return here, settings.same_place_of_hand, box
        return None, inf, None

    def _count(
        self,
        fault: Fault,
        now: TaskTime,
        point: Array | None,
        radius: float,
        shape: Geom | None,
        *,
        is_again: bool,
    ) -> None:
        """Note down a fault that was not there before, or still is after it was cleared."""
        self._present.add(fault.kind)
        alike = (one for one in self._places if _is_same(one, fault.kind, point, radius))
        place = next(alike, None) or _Place(fault.kind, point, now)
        if shape is not None:
            place.shapes += (shape,)
        if is_again or point is not None or place.times == 0:
            place.times, place.last = place.times + 1, now
        self._keep([*(one for one in self._places if one is not place), place])
        if place.times > self._settings.most:
            self.given_up = f"came back {self._settings.most} times: {fault.text}"

    def _keep(self, places: list[_Place]) -> None:
        self._places = places
        hit = tuple(shape for one in places for shape in one.shapes)
        if len(hit) != len(self.hit):
            self.hit = hit

    def _away(self, bearing: float | None, wTb: SE3) -> Array:
        """(2,) unit vector in the base frame: from the side that was touched.

        Where that is not told, or the base cannot drive there, back along where it came from.
        """
        came = _back(self._bases, wTb, self._settings.way_back)
        x, y = (-1.0, 0.0)
        if came is not None:
            x, y, _ = wTb.actInv(came.translation).tolist()
        if bearing is not None and (self._is_holonomic or abs(cos(bearing)) > 0.5):
            x, y = -cos(bearing), -sin(bearing)
        if not self._is_holonomic:
            return np.array([1.0 if x > 0.0 else -1.0, 0.0])
        return np.array([x, y]) / max(hypot(x, y), 1e-9)

    @property
    def _is_holonomic(self) -> bool:
        return len(self._robot.base.axes[0]) == 3

    def _beside_base(self, side: float, wTb: SE3) -> Geom:
        """What stands beside the base on a side [rad], in the world."""
        length, width, height = self._robot.base.size
        c, s, radius = cos(side), sin(side), self._settings.hit_radius
        edge = min(half / max(abs(part), 1e-9) for half, part in ((length, c), (width, s))) / 2.0
        there = np.array([(edge + radius) * c, (edge + radius) * s, height / 2.0])
        return Geom(Cylinder(radius, height / 2.0), SE3(np.eye(3), wTb.act(there)), _WHAT)


def _trace(trail: deque[SE3], here: SE3) -> None:
    """Go on with a trail; what is gone back along it is no longer a part of it."""
    while len(trail) > 1 and _gap(here, trail[-2]) < _gap(here, trail[-1]):
        trail.pop()
    if not trail or _gap(here, trail[-1]) > _STEP:
        trail.append(here)


def _back(trail: deque[SE3], here: SE3, distance: float) -> SE3 | None:
    """Where it was last that was this far away [m]; None if that is not known."""
    return next((place for place in reversed(trail) if _gap(place, here) > distance), None)


def _gap(a: SE3, b: SE3) -> float:
    return float(np.linalg.norm(a.translation - b.translation))


def _is_near(moving: Geom, point: Array | None) -> bool:
    """Whether what moves by itself, seen from above, reaches as far as a point (3,)."""
    if point is None:
        return False
    away = hypot(*(moving.pose.translation - point)[:2].tolist())
    return bool(away < max(half_extents(moving.shape)[:2]) + _NEAR_MOVER)


def _is_same(place: _Place, kind: FaultKind, point: Array | None, radius: float) -> bool:
    if place.kind is not kind:
        return False
    if place.point is None or point is None:
        return place.point is point
    return bool(np.linalg.norm(place.point - point) < radius)
