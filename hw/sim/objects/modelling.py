"""Bodies of exact convex parts: turned, hollow, swept and cut out."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from pinocchio import exp3

from robots import Array, Geom, Hull, hull_of

Profile: TypeAlias = Sequence[tuple[float, float]]  # heights and radii, from below [m]

SIDES = 24  # of a round body, which lies on a side, not on a corner

_ANGLES = (np.arange(SIDES) + 0.5) * (2.0 * np.pi / SIDES)
_CIRCLE = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)


def turned(profile: Profile) -> list[Geom]:
    """A solid of revolution about z, split only where its profile is concave."""
    parts, run = [], [profile[0]]
    for before, point in pairwise(profile):
        if len(run) > 1 and _is_hollow(run[-2], before, point):
            parts.append(_between(run))
            run = [before]
        run.append(point)
    return [*parts, _between(run)]


def hollow(profile: Profile, thickness: float, staves: int = 12) -> list[Geom]:
    """A vessel about z: staves inside a profile from the ground up, and a bottom as thick [m]."""
    (foot, radius), (next_height, next_radius) = profile[0], profile[1]
    share = thickness / (next_height - foot)
    floor = (foot + thickness, radius + share * (next_radius - radius))
    parts = [_between([(foot, radius), floor])]
    each = SIDES // staves
    for (low, wide), (high, wider) in pairwise([floor, *profile[1:]]):
        outer = np.concatenate([_ring(low, wide), _ring(high, wider)])
        inner = np.concatenate([_ring(low, wide - thickness), _ring(high, wider - thickness)])
        both = np.stack([outer, inner]).reshape(4, SIDES, 3)
        for first in range(0, SIDES, each):
            some = np.arange(first, first + each + 1) % SIDES
            parts.append(hull_of(both[:, some].reshape(-1, 3)))
    return parts


def swept(path: Array, width: float, height: float) -> list[Geom]:
    """A hexagonal bar along a path (N, 3) in x and z, one part a segment; width along y [m]."""
    along = np.gradient(path, axis=0)
    across = np.stack([-along[:, 2], along[:, 1], along[:, 0]], axis=1)
    across *= height / 2.0 / np.linalg.norm(across, axis=1, keepdims=True)
    side = np.array([0.0, width / 2.0, 0.0])
    corners = np.stack(
        [sign * (0.6 * across + edge) for sign in (1.0, -1.0) for edge in (side, -side)]
        + [across, -across],
        axis=1,
    )
    rings = path[:, None] + corners
    return [hull_of(np.concatenate(ends)) for ends in pairwise(rings)]


def cut_out(outline: Sequence[tuple[float, float]], low: float, high: float) -> Geom:
    """A plate between two heights; its outline, seen from above, is convex [m]."""
    corners = np.array(outline)
    return hull_of(np.concatenate([np.insert(corners, 2, z, axis=1) for z in (low, high)]))


def lying(parts: Sequence[Geom], tilt: float = 0.0) -> list[Geom]:
    """A body about z, laid on the ground with its axis along x; its top lowered by a tilt [rad]."""
    return turned_over(parts, np.array([0.0, np.pi / 2.0 + tilt, 0.0]))


def turned_over(parts: Sequence[Geom], over: Array) -> list[Geom]:
    """A body turned by a rotation vector (3,), and laid on the ground [rad]."""
    lying = [corners_of(part) @ exp3(over).T for part in parts]
    low = min(float(points[:, 2].min()) for points in lying)
    return [hull_of(points - [0.0, 0.0, low]) for points in lying]


def corners_of(part: Geom) -> Array:
    """(N, 3) corners of a hull in the frame of its body [m]."""
    assert isinstance(part.shape, Hull)
    corners: Array = part.shape.vertices @ part.pose.rotation.T + part.pose.translation
    return corners


def _is_hollow(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    (za, ra), (zb, rb), (zc, rc) = a, b, c
    return (rb - ra) * (zc - zb) < (rc - rb) * (zb - za) - 1e-12


def _between(profile: Profile) -> Geom:
    return hull_of(np.concatenate([_ring(height, radius) for height, radius in profile]))


def _ring(height: float, radius: float) -> Array:
    return np.insert(radius * _CIRCLE, 2, height, axis=1)
