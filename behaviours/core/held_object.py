"""Shapes of the held object, and of objects that the robot has set down."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from behaviours.core.directions import DOWN, points_down
from behaviours.core.log import TaskLog
from config.arrays import Array
from config.poses import MapPose
from robots import Box, Geom, half_extents, reach

_LEAST_HALF = 0.14  # assumed reach along the pads of an object that was not seen whole [m]
_MOST = 0.16  # what was seen to reach farther than this touches something else [m] ...
_MOST_AREA = 0.007  # ... and so does what covers more than this, seen from above [m^2]
_SEEN = 0.01  # error of what was seen: the object may turn as it is gripped [m]
_ABOVE = 0.02  # and above the grasp centre [m]
_UNSEEN_HALF, _UNSEEN_ABOVE = 0.05, 0.08  # of what a tilted hand holds and did not see whole [m]
_RESOLUTION = 0.005  # widths that differ by less are the same shape [m]
_MOST_HALF = 0.08  # assumed of an object once it is set down: more hides the next place [m]
_BESIDE = 0.005  # room between what is set down and what stands there [m]
_NEAR = 0.03  # fingers that close this near to an object may move it [m]

Outline: TypeAlias = npt.NDArray[np.float64] | None


class HeldObject:
    """The shape of what a hand holds, by the log of the task."""

    def __init__(self, log: TaskLog) -> None:
        self._log = log
        self._held: tuple[object, tuple[Geom, ...]] = None, ()  # and what it is the shape of

    @property
    def shape(self) -> tuple[Geom, ...]:
        """In e, empty for an empty hand; the same tuple while grip and width are the same."""
        log, carried, width = self._log, self._log.in_hand, self._log.fingers.width
        grip = carried and (carried, carried.attempts, round(width / _RESOLUTION) * _RESOLUTION)
        if grip != self._held[0]:
            oRe = DOWN.hand if log.last_grasp is None else log.last_grasp.rotation
            held = (_box(width, log.grip_height, oRe, log.grip_outline),) if grip else ()
            self._held = grip, held
        return self._held[1]


class SetDownObjects:
    """Remembers released objects, until the fingers close there again.

    They stand on the map: after some minutes odometry is off by half a metre.
    """

    def __init__(self) -> None:
        self.shapes: tuple[Geom, ...] = ()
        """On the map; the same tuple until it changes."""
        self.extents: tuple[Geom, ...] = ()
        """The same as far as they were seen to reach; nothing is set down there."""

    def add(self, width: float, height: float, mTe: MapPose, outline: Outline = None) -> None:
        """Add what was released at an end-effector pose.

        Args:
            width: distance between the finger pads that held it [m].
            height: of the grasp above the surface [m].
            mTe: the pose.
            outline: (K, 3) in e [m], see `TaskLog.grip_outline`; None if it was not seen.
        """
        # No wider than it was gripped: what was seen with something else hides places beside it.
        narrow = _shortened(_box(width, height, mTe.rotation))
        seen = narrow if _of_one(outline) is None else _box(width, height, mTe.rotation, outline)
        self.shapes += (narrow.moved(mTe),)
        self.extents += (seen.moved(mTe),)

    def grasp(self, point: Array) -> None:
        """Forget what the fingers may move that close at a point (3,) of the map."""
        kept = [k for k, one in enumerate(self.shapes) if not _is_at(one, point)]
        if len(kept) < len(self.shapes):
            self.shapes = tuple(self.shapes[k] for k in kept)
            self.extents = tuple(self.extents[k] for k in kept)

    def forget(self) -> None:
        """Forget all, after a relocalisation."""
        self.shapes = self.extents = ()


def in_hand(outline: Outline, width: float) -> tuple[float, float]:
    """Where what the fingers hold is, as it was seen before they closed and centred it.

    Args:
        outline: (K, 3) in e [m], see `TaskLog.grip_outline`; None if it was not seen.
        width: distance between the finger pads that hold it [m].

    Returns:
        Its middle along the x axis of e [m], and the angle of its longer edge from that [rad]: 0 or
        90 degrees, as the pads lie on one of its faces.
    """
    if (outline := _of_one(outline)) is None:
        return 0.0, 0.0
    import cv2  # slow to import

    (x, _), sides, _ = cv2.minAreaRect(outline[:, :2].astype(np.float32))
    across = abs(width - max(sides)) < abs(width - min(sides))
    return float(x), np.pi / 2.0 if across else 0.0


def reach_on_surface(held: Sequence[Geom], direction: Array) -> float:
    """How far held shapes, set down, may reach from the hand in a direction (3,), all in e [m]."""
    return max((reach(_shortened(one), direction) for one in held), default=0.0)


def way_off(held: Sequence[Geom], set_down: Sequence[Geom], mTe: MapPose) -> Array:
    """(3,) horizontal, on the map, by which held shapes get off what was set down [m].

    All are boxes seen from above; from each the shorter way is taken, one after the other.

    Args:
        held: in e.
        set_down: on the map.
        mTe: where the hand would set down what it holds.
    """
    off = np.zeros(3)
    for one in held:
        for other in set_down:
            off += _apart(one.moved(SE3(mTe.rotation, mTe.translation + off)), other)
    return off


def _apart(one: Geom, other: Geom) -> Array:
    """(3,) the shortest horizontal way of a box out of another one; zero if they are apart."""
    axes = np.concatenate([g.pose.rotation[:, :2].T for g in (one, other)]) * [1.0, 1.0, 0.0]
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    ways = np.concatenate([axes, -axes])
    lengths = [reach(other, way) + reach(one, -way) + _BESIDE for way in ways]
    least = int(np.argmin(lengths))
    shortest: Array = ways[least] * max(0.0, lengths[least])
    return shortest


def _box(width: float, height: float, oRe: Array, outline: Outline = None) -> Geom:
    """From above the grasp centre down to the surface that the object stood on.

    As wide as it was seen to be from above, if that is one object; else a bar as wide as the
    fingers are apart. `oRe` is how the hand was turned.
    """
    if not points_down(oRe):
        return _upright_box(height, oRe, _of_one(outline))
    least = np.array([-_LEAST_HALF, -width / 2.0, -_ABOVE])
    most = np.array([_LEAST_HALF, width / 2.0, max(height, 0.0)])
    if (outline := _of_one(outline)) is not None:
        between_pads = np.array([0.0, width / 2.0])
        least[:2] = np.minimum(outline.min(axis=0)[:2] - _SEEN, -between_pads)
        most[:2] = np.maximum(outline.max(axis=0)[:2] + _SEEN, between_pads)
    half = (most - least) / 2.0
    centre = (most + least) / 2.0
    return Geom(Box((half[0], half[1], half[2])), SE3(np.eye(3), centre), "held")


def _upright_box(height: float, oRe: Array, outline: Outline) -> Geom:
    """What a tilted hand holds: as deep as it is wide, since it was seen from one side alone."""
    down, approach = -oRe[2], np.array([0.0, 0.0, 1.0])
    side = np.cross(down, approach)
    side /= np.linalg.norm(side)
    half, above = _UNSEEN_HALF, _UNSEEN_ABOVE
    if outline is not None:
        half = float(np.abs(outline @ side).max()) + _SEEN
        above = float((outline @ -down).max()) / max(float(np.hypot(*down[:2])), 0.5) + _SEEN
    centre = 0.5 * (height - above) * down
    axes = np.column_stack([np.cross(side, down), side, down])
    return Geom(Box((half, half, 0.5 * (height + above))), SE3(axes, centre), "held")


def _of_one(outline: Outline) -> Outline:
    """What was seen if it is one object that the hand can hold; None if several touch."""
    if outline is None or np.abs(outline).max() > _MOST or _area(outline) > _MOST_AREA:
        return None
    return outline


def _area(outline: Array) -> float:
    """Of a convex outline (K, 3) at z = 0 [m^2]."""
    corners = np.vstack([outline, outline[:1]])
    return 0.5 * float(np.abs(np.cross(corners[:-1], corners[1:]).sum(axis=0)[2]))


def _shortened(held: Geom) -> Geom:
    x, y, z = half_extents(held.shape)
    return Geom(Box((min(x, _MOST_HALF), min(y, _MOST_HALF), z)), held.pose, "what was set down")


def _is_at(one: Geom, point: Array) -> bool:
    local = np.abs(one.pose.actInv(point)) - half_extents(one.shape)
    return bool(local.max() <= _NEAR)
