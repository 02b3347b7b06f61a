"""Grasp feasibility: whether the hand fits and the fingers hold, on a height map.

For a grasp from straight above, the scene is sampled along lines in the closing direction, spread
over the width of the fingers. On each line the solid run around the grasp centre is the body that
the pads close on. Everything else above the finger tips must leave room for the fingers, and
everything above the palm for the palm; what is hidden is in the way of the fingers. The same check
labels training scenes, where heights are exact.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import lru_cache
from math import ceil

import cv2
import numpy as np

from config.arrays import Array, Image, Indices, Mask
from perception.geometry import CAMERA_UP
from perception.grasps.closing_profile import ALONG, contact_edge, flare, free_distances, runs
from perception.grasps.hand_geometry import PALM_SPACING, HandDimensions, hand_dimensions
from perception.grasps.height_map import CELL, HeightMap
from perception.grasps.stereo import TALLEST
from robots import GripperDescription

DEPTHS = (0.014, 0.022, 0.030)
"""Depths of the grasp centre below the surface that are tried, at most half the height [m]."""
FLOOR_CLEARANCE = 0.011  # smallest height of the grasp centre above the floor [m]
FRICTION = 0.5  # coefficient of friction that a grasp may rely on

_PALM_CELLS = ceil(PALM_SPACING / CELL)  # side of the square around each palm point [cells]

_CONTACT_BELOW = 0.006  # the body is measured this far below the grasp centre, near the tips [m]
_CONTACT_ABOVE = 0.004  # ... and this far above it, to see how it widens towards the tips [m]
_FINGER_CLEARANCE = 0.002  # between an open finger and its neighbour [m]
_PALM_CLEARANCE = 0.006  # between the palm and what is under it, for errors of arm and camera [m]
_LEVEL_ERROR = 0.006  # of where the base stands: a level palm comes nearer by so much [m]
_MIN_ROOM = 0.004  # on either side of the object before closing, for errors of the arm [m]
_EXTRA_ROOM = 0.008  # beyond that, where it is free [m]
_MIN_WIDTH = 0.003  # of an object; less is noise [m]
_DEPTH_COST = 0.03  # a deeper grasp must be better by this share: the map hides what is below


@dataclass(frozen=True, kw_only=True)
class _Ramp:
    """A factor of the score: 0 below `worst`, from there `least` rising to 1 at `good`."""

    worst: float
    good: float
    least: float = 0.0

    def __call__(self, value: Array) -> Array:
        rising = self.least + (1.0 - self.least) * (value - self.worst) / (self.good - self.worst)
        return np.where(value < self.worst, 0.0, np.minimum(rising, 1.0))


_CONE = float(np.arctan(FRICTION))  # half angle of the friction cone [rad]
_ENGAGEMENT = _Ramp(worst=0.006, good=0.014, least=0.3)  # height of the object beside the pads [m]
_LIFT = _Ramp(worst=-0.016, good=-0.003, least=0.1)  # by which the palm raises the grasp, < 0 [m]
_ROOM_LEFT = _Ramp(worst=0.0, good=0.006, least=0.5)  # beyond what the open fingers need [m]
_SLOPE = _Ramp(worst=-1.5 * _CONE, good=-0.3 * _CONE)  # of the steeper contact edge, < 0 [rad]
_TAPER = _Ramp(worst=-_CONE, good=-0.3 * _CONE)  # half the angle between the edges, < 0 [rad]
_SKEW = _Ramp(worst=-_CONE, good=-0.5 * _CONE)  # of the line through the contacts, < 0 [rad]
_FLARE = _Ramp(worst=-1.2 * FRICTION, good=-0.25 * FRICTION)  # widening towards the tips, < 0
_CONTACT_LINES = _Ramp(worst=1.0, good=3.0, least=0.1)  # lines that the smaller contact is on


@dataclass(frozen=True, kw_only=True, eq=False)
class Assessment:
    """The feasibility of N grasps. Where `score` is 0 the other values are undefined."""

    score: Array  # (N,) 0 is infeasible, 1 is best
    x: Array  # (N,) midway between the contacts, in odometry [m]
    y: Array  # (N,) [m]
    z: Array  # (N,) height of the grasp centre [m]
    top: Array  # (N,) height of the surface at the grasp [m]
    direction: Array  # (N,) closing direction, from x towards y [rad]
    width: Array  # (N,) distance between the contacts along the closing direction [m]
    opening: Array  # (N,) distance between the pads for a free descent [m]
    offset: Array  # (N,) displacement of the centre along the closing direction [m]
    turn: Array  # (N,) of the closing direction towards the normal of the contacts [rad]

    def only(self, which: Indices | Mask) -> Assessment:
        """A selection of them."""
        return Assessment(**{f.name: getattr(self, f.name)[which] for f in fields(self)})

    def ranked(self, score: Array, preference: Array) -> Assessment:
        """The same grasps with another score, the most preferred first."""
        return replace(self, score=score).only(np.argsort(-preference, kind="stable"))


def assess(
    scene: HeightMap,
    x: Array,
    y: Array,
    direction: Array,
    floor: float,
    gripper: GripperDescription,
    margin: float = 0.0,
) -> Assessment:
    """Assess grasps from straight above, each at the best of `DEPTHS`.

    Args:
        scene: heights, measured or exact.
        x: (N,) grasp centres, as all that follows in the frame of the map [m].
        y: (N,) [m].
        direction: (N,) closing direction, from x towards y [rad].
        floor: height of the support surface in odometry [m].
        gripper: the hand.
        margin: around its fingers [m].
    """
    hand = hand_dimensions(gripper, margin)
    cosine, sine = np.cos(direction), np.sin(direction)
    top = scene.at(x, y).astype(float)
    # Under both edges of the fingers: a tilted hand meets the floor with one of them.
    edge = float(hand.lines[-1])
    left = scene.plane(floor, x - edge * sine, y + edge * cosine)
    below = np.maximum(left, scene.plane(floor, x + edge * sine, y - edge * cosine))
    deepest = np.maximum(0.5 * (top + scene.plane(floor, x, y)), below + FLOOR_CLEARANCE)
    # All depths at once: with so few grasps the overhead of numpy's calls dominates.
    deep = np.maximum(top - np.array(DEPTHS)[:, None], deepest)
    z = np.maximum(deep, _lowest(scene, hand, x, y, cosine, sine, floor))
    possible = (top - (z - hand.tip) >= _ENGAGEMENT.worst) & (deep - z >= _LIFT.worst)
    # Only where the hand fits over the middle line, the others are looked up.
    n = len(hand.lines) // 2
    middle = scene.heights.ravel().take(_cells(scene, x, y, cosine, sine, hand.lines[n : n + 1]))
    left, right, solid = runs(middle[:, 0] > _contact_level(z)[..., None])
    depth, grasp = np.nonzero(possible & solid & (right - left < hand.opening))
    some, which = np.unique(grasp, return_inverse=True)
    cells = _cells(scene, x[some], y[some], cosine[some], sine[some], hand.lines)
    unknown = np.zeros((len(some), len(ALONG)), dtype=np.bool_)
    if scene.unknown is not None:
        unknown = np.asarray(scene.unknown.ravel().take(cells).any(axis=1))
    heights = scene.heights.ravel().take(cells)
    fits, found = _assess_at(
        heights, unknown, which, top[grasp], deep[depth, grasp], z[depth, grasp], hand
    )
    chosen = {name: np.zeros(z.shape) for name in found}
    for name, values in found.items():
        chosen[name][depth[fits], grasp[fits]] = values
    scores = chosen["score"] * (1.0 - _DEPTH_COST * np.arange(len(DEPTHS)))[:, None]
    best = scores.argmax(axis=0), np.arange(len(top))
    chosen = {name: values[best] for name, values in chosen.items()}
    x, y = x + cosine * chosen["offset"], y + sine * chosen["offset"]
    return Assessment(x=x, y=y, top=top, direction=direction, **chosen)


def _assess_at(
    heights: Image,
    unknown: Mask,
    which: Indices,
    top: Array,
    deep: Array,
    z: Array,
    hand: HandDimensions,
) -> tuple[Mask, dict[str, Array]]:
    """Which of K grasps, at one depth each, the hand fits at; the fields of `Assessment` of those.

    Args:
        heights: (N, across, along) around places, in odometry [m].
        unknown: (N, along) where something hidden may be in the way of the fingers.
        which: (K,) the number of each grasp's place.
        top: (K,) height of the surface at the grasp [m].
        deep: (K,) desired height of the grasp centre [m].
        z: (K,) height of the grasp centre, at which neither palm nor camera collides [m].
        hand: dimensions of the hand.
    """
    low = heights[which] > _contact_level(z)[:, None, None]
    left, right, solid = runs(low)
    body_first = np.where(solid, left, np.inf).min(axis=1)
    body_last = np.where(solid, right, -np.inf).max(axis=1)
    pads = hand.pad_lines
    left, right, solid = left[:, pads], right[:, pads], solid[:, pads]
    first = np.where(solid, left, np.inf).min(axis=1)
    last = np.where(solid, right, -np.inf).max(axis=1)
    width, offset = last - first, 0.5 * (first + last)
    highest = heights.max(axis=1)[which]
    high = highest > z.astype(np.float32)[:, None] + np.float32(hand.finger)
    low = highest > _contact_level(z)[:, None]
    spare, opening = _room(low, high, unknown[which], body_first, body_last, offset, hand)
    fits = (body_first > ALONG[0]) & (body_last < ALONG[-1]) & (width > _MIN_WIDTH)
    fits &= spare >= _ROOM_LEFT.worst

    # The rest is only measured where the hand fits.
    left, right, solid = left[fits], right[fits], solid[fits]
    top, deep, z, first, last, width, offset, spare, opening = np.stack(
        [top, deep, z, first, last, width, offset, spare, opening]
    )[:, fits]
    across = hand.lines[None, pads]
    turn_left, lines_left, at_left = contact_edge(left, solid, first, across)
    turn_right, lines_right, at_right = contact_edge(right, solid, last, across)
    above = np.minimum(z + _CONTACT_ABOVE, top - 0.002)
    higher = heights[which[fits], pads] > above.astype(np.float32)[:, None, None]
    widening = flare(higher, first, last) / np.maximum(above - (z - _CONTACT_BELOW), 1e-3)

    skew = np.arctan2(np.abs(at_right - at_left), np.maximum(width, 1e-3))
    steepest = np.maximum(np.abs(turn_left), np.abs(turn_right))
    taper = 0.5 * np.abs(turn_left - turn_right)
    factors = (
        _ENGAGEMENT(top - (z - hand.tip)),
        _LIFT(deep - z),
        _ROOM_LEFT(spare),
        _SLOPE(-steepest),
        _TAPER(-taper),
        _SKEW(-skew),
        _FLARE(-widening),
        _CONTACT_LINES(np.minimum(lines_left, lines_right)),
    )
    return fits, {
        "score": np.prod(np.stack(factors), axis=0),
        "z": z,
        "width": width,
        "opening": opening,
        "offset": offset,
        "turn": -0.5 * (turn_left + turn_right),
    }


def _cells(
    scene: HeightMap, x: Array, y: Array, cosine: Array, sine: Array, lines: Image
) -> Indices:
    """(N, across, along) cells of a map along lines in the closing direction of N grasps."""
    east, north, c, s = (each.astype(np.float32)[:, None, None] for each in (x, y, cosine, sine))
    across = lines[:, None]
    return scene.cells(east + c * ALONG - s * across, north + s * ALONG + c * across)


def _contact_level(z: Array) -> Image:
    """Height over which something is between or in the way of the pads [m]."""
    level: Image = z.astype(np.float32) - np.float32(_CONTACT_BELOW)
    return level


def _lowest(
    scene: HeightMap,
    hand: HandDimensions,
    x: Array,
    y: Array,
    cosine: Array,
    sine: Array,
    floor: float,
) -> Array:
    """(N,) height of the grasp centre below which palm or camera would collide [m]."""
    highest = _highest(scene, floor).ravel()
    x, y, c, s = (each[:, None] for each in (x, y, cosine, sine))
    lowest = np.full(len(x), -np.inf)
    upwards, clearance = None, _PALM_CLEARANCE
    if scene.oRa is not None:
        upwards = c * scene.oRa[2, 1] - s * scene.oRa[2, 0]
        clearance += _LEVEL_ERROR * float(np.hypot(*scene.oRa[:2, 2]))
    for part, (height, along, across) in enumerate(hand.overhead):
        at = x + c * along - s * across, y + s * along + c * across
        at_each = highest.take(scene.cells(*at))
        if part and upwards is not None:  # the camera
            is_clear = (np.abs(upwards) > CAMERA_UP) & (upwards * across < 0.0)
            at_each = np.where(is_clear, -np.inf, at_each)
        under = at_each.max(axis=1)
        lowest = np.maximum(lowest, under + clearance - height)
    return lowest


@lru_cache(maxsize=1)
def _highest(scene: HeightMap, floor: float) -> Image:
    """(rows, columns) the highest around each cell [m].

    Hidden objects are as high as `TALLEST`, or as the camera.
    """
    heights = scene.heights
    if scene.unknown is not None:
        tall = np.asarray(scene.plane(floor + TALLEST, *scene.positions()), dtype=np.float32)
        tallest = np.where(scene.unknown, tall, np.float32(-np.inf))
        if scene.rising is not None:
            tallest[scene.rising] = np.inf
        heights = np.maximum(heights, tallest)
    square = np.ones((_PALM_CELLS, _PALM_CELLS), dtype=np.uint8)
    highest: Image = np.asarray(cv2.dilate(heights, square), dtype=np.float32)
    return highest


def _room(
    low: Mask,
    high: Mask,
    unknown: Mask,
    body_first: Array,
    body_last: Array,
    centre: Array,
    hand: HandDimensions,
) -> tuple[Array, Array]:
    """The room of each finger beyond what it needs, and the opening for the descent [m].

    Args:
        low: (N, along) where anything is in the way of the pads.
        high: (N, along) where anything is in the way of the fingers above them.
        unknown: (N, along) where anything may be in the way of both.
        body_first: (N,) start of the body between the fingers, along the closing direction [m].
        body_last: (N,) its end [m].
        centre: (N,) middle between the fingers [m].
        hand: dimensions of the hand.
    """
    needed = np.maximum(body_last - centre, centre - body_first) + _MIN_ROOM
    free = np.minimum.reduce(
        [
            distance - thickness
            for occupied, thickness in ((low, hand.pad_thickness), (high, hand.finger_thickness))
            for distance in free_distances(unknown | occupied, body_first, body_last, centre)
        ]
    )
    spare = np.minimum(free - _FINGER_CLEARANCE, 0.5 * hand.opening) - needed
    return spare, 2.0 * (needed + np.minimum(0.5 * spare, _EXTRA_ROOM))
