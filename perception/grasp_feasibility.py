"""Would the hand fit, and would the fingers hold? Answered on a height map alone.

For a grasp from straight above, the scene between and beside the fingers is looked at along seven
lines in the closing direction, spread over the finger's width. On each line the solid run around
the grasp's centre is what the pads will close on; whatever else is higher than the finger tips must
leave room for the fingers, and whatever is higher than the palm room for the palm.

The same check labels training scenes, where heights are exact, and refines what the network
proposes, where they were measured.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from perception.arrays import Array, Image, Mask
from perception.height_map import HeightMap, look_up

MAX_OPENING = 0.08
"""Between the pads of the open hand [m]."""
DEPTHS = (0.014, 0.022, 0.030)
"""How deep below the surface the grasp's centre may go, but never below half the height [m]."""
FLOOR_CLEARANCE = 0.011
"""Least height of the grasp's centre above what the objects stand on [m]."""
TIP = 0.0084
"""How far the finger tips reach beyond the grasp's centre [m]."""
PALM = 0.037
"""How far the palm stays behind the grasp's centre [m]."""
FRICTION = 0.5
"""Coefficient of friction that a contact may count on."""

_STEP = 0.0015
_ALONG = np.arange(-42, 43, dtype=np.float32) * np.float32(_STEP)
_CENTRE = len(_ALONG) // 2
_ACROSS = np.array([-10.5, -7.0, -3.5, 0.0, 3.5, 7.0, 10.5], dtype=np.float32) * np.float32(1e-3)
_PAD = slice(1, 6)  # the lines that meet the pads; the outer two meet only the fingers
_MIDDLE = 2  # of the lines that meet the pads
_PALM_ALONG = np.linspace(-0.096, 0.096, 13)
_PALM_ACROSS = np.array([-24.0, -8.0, 8.0, 24.0]) * 1e-3
_PALM_CELLS = 11  # side of the square around each sample [cells]

_CONTACT_BELOW = 0.006  # contact is looked for this far below the grasp's centre [m]
_CONTACT_ABOVE = 0.004  # ... and compared with this far above it
_FINGER_ABOVE = 0.007  # from this far above the grasp's centre fingers are as thick as below
_PAD_THICKNESS = 0.008
_FINGER_THICKNESS = 0.0158
_MARGIN = 0.002  # between a finger and its neighbour [m]
_CLEARANCE = 0.004  # least room on either side of the object before closing [m]
_WISHED_ROOM = 0.008  # beyond that, where there is more
_PALM_CLEARANCE = 0.003
_LEAST_ENGAGEMENT = 0.006
_CONTACT_ZONE = 0.003  # edge points this near to the outermost belong to the contact [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class Assessment:
    """What became of N grasps. Where `score` is 0 the other numbers mean nothing."""

    score: Array
    """(N,) 0 = will not work, 1 = as good as can be."""
    x: Array
    """(N,) centre between the contacts [m]."""
    y: Array
    """(N,) [m]."""
    z: Array
    """(N,) height of the grasp's centre [m]."""
    top: Array
    """(N,) height of the surface at the grasp [m]."""
    width: Array
    """(N,) between the contacts, along the closing direction [m]."""
    opening: Array
    """(N,) between the pads while the hand comes down, so that both fingers stay free [m]."""
    offset: Array
    """(N,) by how far the centre moved, along the closing direction [m]."""
    turn: Array
    """(N,) by how much the closing direction should turn to meet both contacts squarely [rad]."""


def assess(scene: HeightMap, x: Array, y: Array, direction: Array, floor: float) -> Assessment:
    """Judge grasps from straight above, each at the best of `DEPTHS`.

    Args:
        scene: heights, measured or exact.
        x: (N,) grasp centres in the world [m].
        y: (N,) [m].
        direction: (N,) closing direction in the world, from x towards y [rad].
        floor: height of what the objects stand on [m].
    """
    cosine, sine = np.cos(direction), np.sin(direction)
    top = scene.at(x, y).astype(float)
    along, across = _ALONG[None, None, :], _ACROSS[None, :, None]
    c, s = (a.astype(np.float32)[:, None, None] for a in (cosine, sine))
    east, north = (a.astype(np.float32)[:, None, None] for a in (x, y))
    heights = scene.at(east + c * along - s * across, north + s * along + c * across)
    lowest = _highest_under_palm(scene, x, y, cosine, sine) + _PALM_CLEARANCE - PALM
    half_way = np.maximum(0.5 * (top + floor), floor + FLOOR_CLEARANCE)
    # All depths at once: for so few grasps numpy's calls take longer than their work.
    many = len(DEPTHS)
    found = _assess_at(
        np.concatenate([heights] * many),
        np.tile(top, many),
        np.concatenate([np.maximum(top - depth, half_way) for depth in DEPTHS]),
        np.tile(lowest, many),
    )
    # Where depths are equally good the shallowest wins: what is hidden below it does not matter.
    scores = found.score.reshape(many, -1) * (1.0 - 0.03 * np.arange(many))[:, None]
    best = scores.argmax(axis=0), np.arange(len(top))

    def chosen(name: str) -> Array:
        values: Array = getattr(found, name).reshape(many, -1)[best]
        return values

    offset = chosen("offset")
    return Assessment(
        score=chosen("score"),
        x=x + cosine * offset,
        y=y + sine * offset,
        z=chosen("z"),
        top=top,
        width=chosen("width"),
        opening=chosen("opening"),
        offset=offset,
        turn=chosen("turn"),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _AtDepth:
    """What `Assessment` says, for one depth; all (N,)."""

    score: Array
    z: Array
    width: Array
    opening: Array
    offset: Array
    turn: Array


def _assess_at(heights: Image, top: Array, deep: Array, lowest: Array) -> _AtDepth:
    """Judge grasps at one depth each.

    Args:
        heights: (N, across, along) about each grasp, in the world [m].
        top: (N,) of the surface at the grasp [m].
        deep: (N,) where the grasp's centre should go [m].
        lowest: (N,) no lower may it go, for the palm [m].
    """
    z = np.maximum(deep, lowest)
    engagement = top - (z - TIP)
    level = z.astype(np.float32)[:, None, None]
    low = heights > level - np.float32(_CONTACT_BELOW)
    left, right, solid = _runs(low)
    body_first = np.where(solid, left, np.inf).min(axis=1)
    body_last = np.where(solid, right, -np.inf).max(axis=1)
    left, right, solid = left[:, _PAD], right[:, _PAD], solid[:, _PAD]
    first = np.where(solid, left, np.inf).min(axis=1)
    last = np.where(solid, right, -np.inf).max(axis=1)
    whole = solid[:, _MIDDLE] & (body_first > _ALONG[0]) & (body_last < _ALONG[-1])
    first, last, body_first, body_last = (
        np.where(whole, end, 0.0) for end in (first, last, body_first, body_last)
    )
    width, offset = last - first, 0.5 * (first + last)

    high = heights > level + np.float32(_FINGER_ABOVE)
    spare, opening = _room(low, high, body_first, body_last, offset)

    turn_left, lines_left, at_left = _edge(left, solid, first)
    turn_right, lines_right, at_right = _edge(right, solid, last)
    above = np.minimum(z + _CONTACT_ABOVE, top - 0.002)
    flare = _flare(heights[:, _PAD] > above.astype(np.float32)[:, None, None], first, last)
    flare /= np.maximum(above - (z - _CONTACT_BELOW), 1e-3)

    skew = np.arctan2(np.abs(at_right - at_left), np.maximum(width, 1e-3))
    steepest = np.maximum(np.abs(turn_left), np.abs(turn_right))
    taper = 0.5 * np.abs(turn_left - turn_right)
    cone = np.arctan(FRICTION)
    factors = (
        _fade(engagement, _LEAST_ENGAGEMENT, 0.014, least=0.3),
        _fade(deep - z, -0.016, -0.003, least=0.1),
        _fade(MAX_OPENING - 0.002 - width, 0.0, 0.006, least=0.2),
        _fade(spare, 0.0, 0.006, least=0.5),
        _fade(-steepest, -1.5 * cone, -0.3 * cone),
        _fade(-taper, -cone, -0.3 * cone),
        _fade(-skew, -cone, -0.5 * cone),
        _fade(-flare, -1.2 * FRICTION, -0.25 * FRICTION),
        _fade(np.minimum(lines_left, lines_right), 1.0, 3.0, least=0.1),
        whole & (width > 0.003),
    )
    return _AtDepth(
        score=np.prod(np.stack([np.asarray(f, dtype=float) for f in factors]), axis=0),
        z=z,
        width=width,
        opening=opening,
        offset=offset,
        turn=-0.5 * (turn_left + turn_right),
    )


def _fade(value: Array, worst: float, good: float, least: float = 0.0) -> Array:
    """0 below `worst`, from there `least` rising to 1 at `good`."""
    rising = least + (1.0 - least) * (value - worst) / (good - worst)
    return np.where(value < worst, 0.0, np.minimum(rising, 1.0))


def _highest_under_palm(scene: HeightMap, x: Array, y: Array, cosine: Array, sine: Array) -> Array:
    square = np.ones((_PALM_CELLS, _PALM_CELLS), dtype=np.uint8)
    highest = np.asarray(cv2.dilate(scene.heights, square), dtype=np.float32)
    along, across = (grid.ravel()[None, :] for grid in np.meshgrid(_PALM_ALONG, _PALM_ACROSS))
    c, s = cosine[:, None], sine[:, None]
    under = look_up(
        highest,
        scene.origin,
        scene.cell,
        x[:, None] + c * along - s * across,
        y[:, None] + s * along + c * across,
    )
    return np.asarray(under.max(axis=1), dtype=float)


def _runs(occupied: Mask) -> tuple[Array, Array, Mask]:
    """Ends of the solid run around the middle of each line [m], and whether there is one.

    A run that does not end on the line ends where the line does.
    """
    free = ~occupied
    to_right = free[..., _CENTRE:]
    right = np.where(to_right.any(-1), to_right.argmax(-1), to_right.shape[-1])
    to_left = free[..., _CENTRE::-1]
    left = np.where(to_left.any(-1), to_left.argmax(-1), to_left.shape[-1])
    return -(left - 0.5) * _STEP, (right - 0.5) * _STEP, occupied[..., _CENTRE]


def _room(
    low: Mask, high: Mask, body_first: Array, body_last: Array, centre: Array
) -> tuple[Array, Array]:
    """How much farther than needed the fingers could open, and how far they should [m].

    Args:
        low: (N, across, along) what is in the way of the pads.
        high: (N, across, along) what is in the way of the fingers above them.
        body_first: (N,) where the body between the fingers begins along the closing direction [m].
        body_last: (N,) where it ends [m].
        centre: (N,) where the middle between the fingers is [m].
    """
    needed = np.maximum(body_last - centre, centre - body_first) + _CLEARANCE
    free = np.minimum.reduce(
        [
            distance - thickness
            for occupied, thickness in ((low, _PAD_THICKNESS), (high, _FINGER_THICKNESS))
            for distance in _free(np.asarray(occupied.any(axis=1)), body_first, body_last, centre)
        ]
    )
    spare = np.minimum(free - _MARGIN, 0.5 * MAX_OPENING) - needed
    return spare, 2.0 * (needed + np.minimum(0.5 * spare, _WISHED_ROOM))


def _free(blocked: Mask, body_first: Array, body_last: Array, centre: Array) -> tuple[Array, Array]:
    """Distances from the centre to the first thing beyond the body, to either side [m].

    Args:
        blocked: (N, along) whether anything is in the way of the fingers.
        body_first: (N,) where the body begins along the closing direction [m].
        body_last: (N,) where it ends [m].
        centre: (N,) from where to measure [m].
    """
    beyond = np.where(blocked & (body_last[:, None] < _ALONG), _ALONG, np.inf).min(axis=1)
    before = np.where(blocked & (body_first[:, None] > _ALONG), _ALONG, -np.inf).max(axis=1)
    return beyond - 0.5 * _STEP - centre, centre - before - 0.5 * _STEP


def _edge(ends: Array, solid: Mask, outermost: Array) -> tuple[Array, Array, Array]:
    """Slope of the contact edge [rad], how many lines it is on, and where across it is [m]."""
    weight = (solid & (np.abs(ends - outermost[:, None]) < _CONTACT_ZONE)).astype(float)
    lines = weight.sum(axis=1)
    total = np.maximum(lines, 1.0)
    across = _ACROSS[None, _PAD]
    centre = (weight * across).sum(axis=1) / total
    mean = (weight * ends).sum(axis=1) / total
    spread = (weight * (across - centre[:, None]) ** 2).sum(axis=1)
    slope = (weight * (across - centre[:, None]) * (ends - mean[:, None])).sum(axis=1)
    slope = np.where(lines >= 2, slope / np.maximum(spread, 1e-9), 0.0)
    return np.arctan(slope), lines, centre


def _flare(above: Mask, first: Array, last: Array) -> Array:
    """By how much the body is wider at the tips than higher up, on its worse side [m]."""
    left, right, solid = _runs(above)
    left = np.where(solid, left, np.inf).min(axis=1)
    right = np.where(solid, right, -np.inf).max(axis=1)
    some = solid.any(axis=1)
    flare = np.maximum(left - first, last - right)
    return np.where(some, flare, 1.0)
