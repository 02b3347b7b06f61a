"""Memory of the robot's faults: places, counts, pauses before clearing, and ways out."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, sin

import numpy as np
from pinocchio import SE3

from config.poses import MapFromOdometry, OdometryPose
from controller import Array, Obstacle
from hw import RECOVERY_MEMORY, RECOVERY_PAUSES, Fault, FaultKind, RobotState, TaskTime
from robots import Box, Cylinder, Geom, RobotDescription, half_extents

_STEP = 0.01  # between the recorded poses of base and hand [m]
_STEPS = 60  # recorded poses
_NEAR_MOVER = 0.2  # a contact nearer than this to a moving obstacle is with that [m]
_MOST = 3  # recoveries at the same place, after which a person has to help
_SAME_PLACE = 0.5  # of the base [m]
_SAME_PLACE_OF_HAND = 0.1  # [m]
_REMEMBERED = 300.0  # a contact counts and blocks this long: it may have been a person [s], ...
_HAND_BLOCKS = 60.0  # ... and one of the hand blocks so long: where it touched is a guess [s]
_HIT_RADIUS = 0.08  # of the upright cylinder at a contact of the base [m]
_HIT_HALF = 0.02  # half edge of the box at a contact of the hand [m]
_WAY_BACK = 0.05  # along its path, before the hand rises [m]
_LEFT = 0.1  # the hand has left what it touched, which is a guess, from here on [m]
_DRIVING = 0.1  # a faster base has brought the arm to what it touched [m/s]
_WHAT = "what was hit"
"""Name of the shape at a contact."""


@dataclass(eq=False)
class _Place:
    """Where faults of one kind occurred."""

    kind: FaultKind
    point: Array | None
    """(3,) on the map [m]; None if it was no contact."""
    last: TaskTime
    times: int = 0
    shapes: tuple[Geom, ...] = ()
    """Obstacles there, on the map, from which odometry drifts."""
    left_behind: Geom | None = None
    """That at the hand, in odometry, until the hand, which it would push anywhere, has left it."""

    def clear(self) -> None:
        """Forget the obstacles, not the count."""
        self.shapes, self.left_behind = (), None


@dataclass(frozen=True, kw_only=True, eq=False)
class WayOut:
    """How to leave a contact."""

    base: Array | None
    """(2,) unit vector in the base frame; None if the base stays."""
    hand: SE3 | None
    """Where the hand came from, in odometry; None if the arm was not touched, or the base drove it
    into something: then the base takes it back.
    """


class FaultMemory:
    """Records every fault of a run, whichever leaf clears it, and when that is allowed.

    A contact is one of the base (bumper) or the arm (reflex). It leaves an obstacle: an upright
    cylinder beside the base, a small box at the hand; unless a moving obstacle was there, or the
    hand was allowed to touch. A relocalisation removes the obstacles; after a minute that at the
    hand is forgotten; after five minutes, and when a person acknowledges, everything.

    Args:
        robot: its description.
    """

    def __init__(self, robot: RobotDescription) -> None:
        self._robot = robot
        self._places: list[_Place] = []
        self._present: set[FaultKind] = set()
        """Kinds of the present faults."""
        self._since: TaskTime | None = None
        self._cleared: list[TaskTime] = []
        self._is_tried = False
        """Whether the present or last faults have been cleared."""
        self._bases: deque[SE3] = deque(maxlen=_STEPS)
        self._hands: deque[SE3] = deque(maxlen=_STEPS)
        self._drove = False
        """Whether the base was driving before the present faults."""
        self._way_out: tuple[WayOut, SE3] | None = None
        self.given_up = ""
        """The fault that came back too often; empty as long as a program may clear it."""
        self.hit: tuple[Geom, ...] = ()
        """Obstacles at contacts, on the map; the same tuple until it changes."""

    def note(
        self,
        state: RobotState,
        oTe: OdometryPose,
        now: TaskTime,
        moving: Sequence[Obstacle] = (),
        *,
        mTo: MapFromOdometry,
        at_work: bool = False,
    ) -> None:
        """Take a reading.

        Args:
            state: the reading.
            oTe: of the end effector then.
            now: the task's time.
            moving: obstacles.
            mTo: odometry on the map.
            at_work: whether the hand was allowed to touch.
        """
        kept = [one for one in self._places if now.since(one.last) < _REMEMBERED]
        for one in kept:
            if one.kind is FaultKind.REFLEX and now.since(one.last) > _HAND_BLOCKS:
                one.clear()
            elif (box := one.left_behind) is not None and _gap(box.pose, oTe) > _LEFT:
                one.shapes, one.left_behind = (*one.shapes, box.moved(mTo)), None
        if self._places:
            self._keep(kept)
        if not state.faults:
            self._since = None
            self._present.clear()
            _trace(self._bases, state.oTb)
            _trace(self._hands, oTe)
            self._drove = hypot(*state.base_twist[:2].tolist()) > _DRIVING
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
                where, radius, shape = self._contact(fault, state, oTe, at_work=at_work)
                touched = where if shape is None else shape.pose.translation
                if any(_is_near(one.geom, touched) for one in moving):
                    shape = None  # who tells of it tells where it is now
                elif at_work and fault.kind is FaultKind.REFLEX:
                    shape = None
                self._count(fault, now, where, radius, shape, mTo, is_again=is_again)

    def wait(self, now: TaskTime) -> float:
        """How long to wait before the present faults may be cleared [s]."""
        self._cleared = [one for one in self._cleared if now.since(one) < RECOVERY_MEMORY]
        wait = RECOVERY_PAUSES[0] - now.since(self._since or now)
        if self._cleared:
            pause = RECOVERY_PAUSES[min(len(self._cleared), len(RECOVERY_PAUSES) - 1)]
            wait = max(wait, pause - now.since(self._cleared[-1]))
        return max(0.0, wait)

    def clear(self, now: TaskTime) -> None:
        """Note that the present faults are being cleared."""
        self._cleared.append(now)
        self._is_tried = True

    def acknowledge(self) -> None:
        """A person has removed the cause: forget everything."""
        self.given_up = ""
        self._is_tried, self._cleared = True, []
        self._keep([])

    def relocalise(self) -> None:
        """Forget the obstacles, whose places are no longer known, but not the counts."""
        for place in self._places:
            place.clear()
        self._keep(self._places)
        self._bases.clear()
        self._hands.clear()
        if self._way_out is not None:
            way, oTb = self._way_out
            self._way_out = WayOut(base=way.base, hand=None), oTb

    def take_way_out(self, oTb: OdometryPose) -> WayOut | None:
        """The way out of the last contact, once; None if the base, now at oTb, has left it."""
        found, self._way_out = self._way_out, None
        if found is None:
            return None
        way, oTb_then = found
        gone = np.linalg.norm(oTb.translation - oTb_then.translation)
        return way if gone < _SAME_PLACE else None

    def _contact(
        self, fault: Fault, state: RobotState, oTe: OdometryPose, *, at_work: bool
    ) -> tuple[Array | None, float, Geom | None]:
        """Place (3,), radius of the same place [m] and obstacle of a contact; sets the way out.

        The place of a contact of the base is that of the base, which may turn between two contacts.
        """
        oTb = state.oTb
        before = WayOut(base=None, hand=None) if self._way_out is None else self._way_out[0]
        if fault.kind is FaultKind.BUMPER:
            away = self._away(fault.bearing, oTb)
            side = atan2(-away[1], -away[0]) if fault.bearing is None else fault.bearing
            cylinder = self._beside_base(side, oTb)
            self._way_out = WayOut(base=away, hand=before.hand), oTb
            return oTb.translation, _SAME_PLACE, cylinder
        if fault.kind is FaultKind.REFLEX:
            if self._drove and not at_work and before.base is None:
                way = WayOut(base=self._away(None, oTb), hand=None)
            else:
                back = _back(self._hands, oTe, _WAY_BACK)
                way = WayOut(base=before.base, hand=oTe if back is None else back)
            self._way_out = way, oTb
            here = oTe.translation
            box = Geom(Box((_HIT_HALF,) * 3), SE3(np.eye(3), here), _WHAT)
            return here, _SAME_PLACE_OF_HAND, box
        return None, inf, None

    def _count(
        self,
        fault: Fault,
        now: TaskTime,
        point: Array | None,
        radius: float,
        shape: Geom | None,
        mTo: MapFromOdometry,
        *,
        is_again: bool,
    ) -> None:
        """Count a fault that is new, or was cleared and is still present."""
        self._present.add(fault.kind)
        point = None if point is None else mTo.act(point)
        same = (one for one in self._places if _is_same(one, fault.kind, point, radius))
        place = next(same, None) or _Place(fault.kind, point, now)
        if shape is not None and fault.kind is FaultKind.REFLEX:
            place.left_behind = shape
        elif shape is not None:
            place.shapes += (shape.moved(mTo),)
        if is_again or point is not None or place.times == 0:
            place.times, place.last = place.times + 1, now
        self._keep([*(one for one in self._places if one is not place), place])
        if place.times > _MOST:
            self.given_up = f"came back {_MOST} times: {fault.text}"

    def _keep(self, places: list[_Place]) -> None:
        self._places = places
        hit = tuple(shape for one in places for shape in one.shapes)
        if len(hit) != len(self.hit):
            self.hit = hit

    def _away(self, bearing: float | None, oTb: OdometryPose) -> Array:
        """(2,) unit vector in the base frame: away from the touched side.

        If that is not known, or the base cannot drive there, back along its path.
        """
        came = _back(self._bases, oTb, _WAY_BACK)
        x, y = (-1.0, 0.0)
        if came is not None:
            x, y, _ = oTb.actInv(came.translation).tolist()
        is_holonomic = len(self._robot.base.axes[0]) == 3
        if bearing is not None and (is_holonomic or abs(cos(bearing)) > 0.5):
            x, y = -cos(bearing), -sin(bearing)
        if not is_holonomic:
            return np.array([1.0 if x > 0.0 else -1.0, 0.0])
        return np.array([x, y]) / max(hypot(x, y), 1e-9)

    def _beside_base(self, side: float, oTb: OdometryPose) -> Geom:
        """The obstacle beside the base on a side [rad], in odometry."""
        length, width, height = self._robot.base.size
        c, s, radius = cos(side), sin(side), _HIT_RADIUS
        edge = min(half / max(abs(part), 1e-9) for half, part in ((length, c), (width, s))) / 2.0
        there = np.array([(edge + radius) * c, (edge + radius) * s, height / 2.0])
        return Geom(Cylinder(radius, height / 2.0), SE3(np.eye(3), oTb.act(there)), _WHAT)


def _trace(trail: deque[SE3], here: SE3) -> None:
    """Append to a trail, without the part that was gone back along."""
    while len(trail) > 1 and _gap(here, trail[-2]) < _gap(here, trail[-1]):
        trail.pop()
    if not trail or _gap(here, trail[-1]) > _STEP:
        trail.append(here)


def _back(trail: deque[SE3], here: SE3, distance: float) -> SE3 | None:
    """The last pose that was this far away [m]; None if there is none."""
    return next((place for place in reversed(trail) if _gap(place, here) > distance), None)


def _gap(a: SE3, b: SE3) -> float:
    return hypot(*(a.translation - b.translation).tolist())


def _is_near(moving: Geom, point: Array | None) -> bool:
    """Whether a moving obstacle, seen from above, is near a point (3,)."""
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
