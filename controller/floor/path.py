"""Paths of the base: straight lines with round corners, and speed profiles."""

from collections.abc import Callable
from math import ceil, cos, hypot, sin, tan
from typing import NamedTuple, TypeAlias

import numpy as np

from config.arrays import Array
from config.planar import wrap

Clearance: TypeAlias = Callable[[Array], Array]  # distances (N,) of points (N, 2) to obstacles [m]
StandsFree: TypeAlias = Callable[[Array], Array]
"""Distances (N,) of the base at poses x, y, heading (N, 3) to obstacles [m]."""
IsFree: TypeAlias = Callable[[Array], bool]  # whether the base may be at poses (N, 3)

SPACING = 0.05  # spacing of the points of a path [m]
_MAX_RADIUS = 1.2  # of the arcs in corners [m] ...
_MIN_RADIUS = 0.12  # ... and where none larger than this fits, the base turns on the spot [m]
_TIGHTER = 0.65  # ratio of successive radii that are tried
_SHARP = 2.4  # sharper corners are not rounded [rad]
_BLUNT = 0.03  # blunter corners are ignored [rad]
_TURNING = 0.85  # share of the turn rate that an arc takes
_SIDEWAYS = 1.0  # largest lateral acceleration [m/s^2]
_BRAKING = 0.8  # deceleration along a path [m/s^2]
_TIGHT_SPEED = 0.3  # largest speed at the distance `_TIGHT` to an obstacle [m/s] ...
_TIGHT = 0.02  # ... [m], ...
_TIGHT_SLOPE = 6.0  # ... and its increase with more distance [1/s]
_CREEP = 0.08  # least speed on a path [m/s]


class Path(NamedTuple):
    """A path that the base follows without stopping."""

    points: Array  # (N, 3) x, y and the heading of the path [m, rad]
    speeds: Array  # (N,) speed profile [m/s]
    times: Array  # (N,) time to the end [s]
    bends: tuple[int, ...]  # indices of the ends of arcs


def pull_straight(way: Array, clearance: Clearance, enough: float) -> Array:
    """The corners of a way (N, 2) after shortcuts.

    A shortcut keeps the distance to obstacles of the part that it replaces, or `enough` [m].
    """
    room = np.minimum(clearance(way), enough) - 1e-6
    corners, here, last = [0], 0, len(way) - 1
    while here < last:
        ahead = last - here
        while ahead > 1:
            count = ceil(hypot(*(way[here + ahead] - way[here]).tolist()) / SPACING) + 1
            line = np.linspace(way[here], way[here + ahead], count)
            if (clearance(line) >= room[here : here + ahead + 1].min()).all():
                break
            ahead = ahead * 3 // 4
        here += max(1, ahead)
        corners.append(here)
    return way[corners]


def paths_along(
    corners: Array, stands_free: StandsFree, is_free: IsFree, speed: float, turn_rate: float
) -> list[Path]:
    """Paths between corners (N, 2) [m]; the base turns on the spot between paths.

    `speed` is that on straight lines [m/s], `turn_rate` the largest [rad/s]. There are no paths
    where all corners are the same.
    """
    paths: list[Path] = []
    pieces: list[tuple[Array, float]] = []  # of one path, with their curvatures [1/m]
    steps = np.diff(corners, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    corners = corners[np.concatenate([[True], lengths > 1e-3])]
    steps = np.diff(corners, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1]).tolist()
    headings = np.arctan2(steps[:, 1], steps[:, 0]).tolist()
    here = corners[0]
    for k, heading in enumerate(headings):
        corner, arc = corners[k + 1], None
        last = k + 1 == len(lengths)
        if not last:
            turn = wrap(headings[k + 1] - heading)
            before = hypot(*(corner - here).tolist())
            after = lengths[k + 1] * (1.0 if k + 2 == len(lengths) else 0.5)
            arc = _arc(corner, heading, turn, min(before, after), is_free)
        straight = _straight(here, corner if arc is None else arc[0, :2], heading)
        pieces.append((straight, 0.0))
        here = corner
        if arc is not None:
            length = float(np.hypot(*np.diff(arc[:, :2], axis=0).T).sum())
            pieces.append((arc, abs(turn) / max(1e-6, length)))
            here = arc[-1, :2]
        elif last or abs(turn) > _BLUNT:
            paths.append(_timed(pieces, stands_free, speed, turn_rate))
            pieces = []
    return paths


def path_at(x: float, y: float, heading: float) -> Path:
    """The path of a base that only has to turn."""
    points = np.array([[x, y, heading]] * 2)
    return Path(points, np.full(2, _CREEP), np.zeros(2), ())


def _straight(a: Array, b: Array, heading: float) -> Array:
    count = max(2, ceil(hypot(*(b - a).tolist()) / SPACING) + 1)
    return np.column_stack([np.linspace(a, b, count), np.full(count, heading)])


def _arc(
    corner: Array, heading: float, turn: float, room: float, is_free: Callable[[Array], bool]
) -> Array | None:
    """Poses (N, 3) on the largest free arc around a corner that leaves from `room` before it."""
    if not _BLUNT < abs(turn) < _SHARP:
        return None
    slope = tan(abs(turn) / 2.0)
    radius = min(_MAX_RADIUS, room / slope)
    side = 1.0 if turn > 0.0 else -1.0
    while radius > _MIN_RADIUS:
        tangent = radius * slope
        start = corner - tangent * np.array([cos(heading), sin(heading)])
        centre = start + side * radius * np.array([-sin(heading), cos(heading)])
        angles = heading + np.linspace(0.0, turn, max(3, ceil(radius * abs(turn) / SPACING) + 1))
        offset = side * radius * np.column_stack([np.sin(angles), -np.cos(angles)])
        arc = np.column_stack([centre + offset, angles])
        if is_free(arc):
            return arc
        radius *= _TIGHTER
    return None


def _timed(
    pieces: list[tuple[Array, float]], stands_free: StandsFree, speed: float, turn_rate: float
) -> Path:
    """The path along poses (N, 3) with curvatures, as fast as it can be to end at rest."""
    points = np.concatenate([poses for poses, _ in pieces])
    ends = np.cumsum([len(poses) for poses, _ in pieces])
    bends = tuple(int(end) - 1 for end, (_, bend) in zip(ends, pieces, strict=True) if bend > 0.0)
    curved = np.maximum(np.concatenate([np.full(len(poses), bend) for poses, bend in pieces]), 1e-6)
    room = _TIGHT_SPEED + _TIGHT_SLOPE * np.maximum(0.0, stands_free(points) - _TIGHT)
    turning = np.minimum(_TURNING * turn_rate / curved, np.sqrt(_SIDEWAYS / curved))
    most = np.minimum(np.minimum(speed, room), turning)
    steps = np.hypot(*np.diff(points[:, :2], axis=0).T)
    speeds, gains = most.tolist(), (2.0 * _BRAKING * steps).tolist()
    speeds[-1] = 0.0
    for k in range(len(speeds) - 2, -1, -1):
        speeds[k] = min(speeds[k], (speeds[k + 1] ** 2 + gains[k]) ** 0.5)
    allowed = np.maximum(speeds, _CREEP)
    taken = steps / (0.5 * (allowed[1:] + allowed[:-1]))
    times = np.concatenate([np.cumsum(taken[::-1])[::-1], [0.0]])
    return Path(points, allowed, times, bends)
