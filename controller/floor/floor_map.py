"""Floor map: distance fields of the static obstacles, seen from above.

Distances are exact at the points of a grid and interpolated between them.
"""

from math import hypot

import numpy as np

from config.arrays import Array, Indices, Mask
from config.planar import Pose2D, act
from controller.floor.cost_field import CELL, CostField, Floor
from controller.floor.footprints import Footprint, footprint
from robots import Geom, Hull, RobotDescription, reach

FAR = 1.0  # largest distance of a point in the map [m]
NEAR = 0.7  # largest distance of the base in the map [m]
_RESOLUTION = 0.05  # grid spacing [m]
_FLAT = 0.002  # lower obstacles belong to the floor [m]
_OVER_BASE = 0.02  # clearance that the base needs above it [m]
COLUMN = 0.70  # height of the arm's column, which stands above its foot in every posture [m]
_SPARE = 0.01  # the base fits where its inscribed circle has this much clearance [m]
_TURNING_ROOM = 0.04  # it turns where its circumscribed circle has this much clearance [m]
_PASSAGE = 1.5  # width of the free strip around the obstacles, besides `FAR` [m]
_ON_LINE = 24  # number of points at which a line is checked
_SPACING = 0.05  # spacing of the points on the edge of the base [m]


class FloorMap:
    """Free room for the base of one robot and the column of its arm; planes are the floor."""

    def __init__(self, fixtures: tuple[Geom, ...], description: RobotDescription) -> None:
        self.fixtures = fixtures
        length, width, height = description.base.size
        foot = float(description.bTa.translation[2])
        mast = [part.moved(description.bTa) for part in description.arm.collision[0]]
        top = max([foot + COLUMN, *(reach(part, np.array([0.0, 0.0, 1.0])) for part in mast)])
        bands = ((_FLAT, height + _OVER_BASE), (foot, top))
        standing = [[footprint(fixture, *band) for band in bands] for fixture in fixtures]
        known = [found for both in standing for found in both if found is not None]
        self.free = not known  # whether there are no obstacles
        self.inscribed = min(length, width) / 2.0  # radius of the circle inside the footprint [m]
        self.circumscribed = hypot(length, width) / 2.0  # radius of the circle around it [m]
        self.turning = self.circumscribed + _TURNING_ROOM
        """Distance of obstacles from the base's centre at which it can turn [m]."""
        self._low, self._high = _around(known)
        layers = _distances(standing, self._low, self._high)
        self._base, self._column = (_Grid(self._low, layer) for layer in layers)
        self._both = _Grid(self._low, layers.min(axis=0))
        self._footprint = _base_discs(length, width)
        self._foot = _column_discs(description)
        self._floor = None if self.free else self._graph()

    def clearance(self, points: Array) -> Array:
        """Distances (N,) from points (N, 2) to obstacles of any height, at most `FAR` [m]."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        return self._both.at(points[:, 0], points[:, 1])

    def has_straight_way(self, here: tuple[float, float], places: Array) -> Mask:
        """Whether lines (N,) to places (N, 2) come no nearer to obstacles than their ends.

        Nearer does not count where the base can turn.
        """
        lines = np.linspace(np.broadcast_to(here, places.shape), places, _ON_LINE)
        room = self._both.at(lines[..., 0], lines[..., 1])
        enough = np.minimum(np.minimum(room[0], room[-1]), self.turning)
        free: Mask = room.min(axis=0) >= enough - _SPARE
        return free

    def stands_free(self, bases: Array | Pose2D) -> Array:
        """Distances (N,) of base and arm column at poses x, y, heading (N, 3) to obstacles [m].

        Not positive where they overlap, and at most `NEAR`.
        """
        bases = np.asarray(bases, dtype=float).reshape(-1, 3)
        if self.free:
            return np.full(len(bases), NEAR)
        least = []
        for grid, (dx, dy, r) in ((self._base, self._footprint), (self._column, self._foot)):
            room = grid.at(*act(bases.T[:, :, None], dx, dy))
            least.append((room - r).min(axis=1))
        clearance: Array = np.minimum(*least)
        return np.minimum(clearance, NEAR)

    def field(self, goal: tuple[float, float]) -> CostField:
        """The cost to drive to a place from anywhere; see `CostField`."""
        return CostField(self._floor, goal)

    def _graph(self) -> Floor:
        low, high = self._low - _PASSAGE, self._high + _PASSAGE
        axes = [np.arange(a, b, CELL) for a, b in zip(low, high, strict=True)]
        room = self._both.at(*np.meshgrid(*axes, indexing="ij"))
        return Floor(low, room, self.inscribed + _SPARE, self.turning)


class _Grid:
    """Distances (n, m) on a grid whose first point is at `low` (x, y) [m]."""

    def __init__(self, low: Array, distances: Array) -> None:
        self._low = low
        self._d = distances

    def at(self, x: Array, y: Array) -> Array:
        """Interpolated distances at coordinates of any shape [m]."""
        d = self._d
        columns = d.shape[1]
        u = np.clip((x - self._low[0]) * (1.0 / _RESOLUTION), 0.0, d.shape[0] - 1.001)
        v = np.clip((y - self._low[1]) * (1.0 / _RESOLUTION), 0.0, columns - 1.001)
        i: Indices = u.astype(np.int64)
        j = v.astype(np.int64)
        u -= i
        v -= j
        i *= columns
        i += j
        flat = d.ravel()
        a, b = flat.take(i), flat.take(i + columns)
        a += (flat.take(i + 1) - a) * v
        b += (flat.take(i + columns + 1) - b) * v
        found: Array = a + (b - a) * u
        return found


def _around(footprints: list[Footprint]) -> tuple[Array, Array]:
    """Least and largest x and y at which an obstacle is nearer than `FAR` [m]."""
    if not footprints:
        return np.zeros(2), np.full(2, FAR)
    low = np.min([(f.corners - f.radius).min(axis=0) for f in footprints], axis=0) - FAR
    high = np.max([(f.corners + f.radius).max(axis=0) for f in footprints], axis=0) + FAR
    return low, high


def _distances(standing: list[list[Footprint | None]], low: Array, high: Array) -> Array:
    """Distances (layers, n, m) to the nearest footprint of each layer, negative inside [m]."""
    n, m = np.ceil((high - low) / _RESOLUTION).astype(int) + 1
    distances = np.full((len(standing[0]) if standing else 2, n, m), FAR)
    x = low[0] + _RESOLUTION * np.arange(n)
    y = low[1] + _RESOLUTION * np.arange(m)
    for layers in standing:
        before, here = None, np.zeros(0)
        for layer, found in zip(distances, layers, strict=True):
            if found is None:
                continue
            least, most = _around([found])
            i, j = (
                slice(np.searchsorted(axis, a), np.searchsorted(axis, b))
                for axis, a, b in zip((x, y), least, most, strict=True)
            )
            if before is None or not found.equals(before):  # as that of what is tall
                here = found.distances(x[i, None], y[None, j])
            before = found
            np.minimum(layer[i, j], here, out=layer[i, j])
    return distances


def _base_discs(length: float, width: float) -> Array:
    """(3, N) x, y and radius of discs that cover the base; its edge as points."""
    x = np.linspace(-length / 2.0, length / 2.0, round(length / _SPACING) + 1)
    y = np.linspace(-width / 2.0, width / 2.0, round(width / _SPACING) + 1)[1:-1]
    discs = [(a, b, 0.0) for a in x for b in (-width / 2.0, width / 2.0)]
    discs += [(a, b, 0.0) for a in (-length / 2.0, length / 2.0) for b in y]
    inscribed, corner = min(length, width) / 2.0, _SPACING
    for r, count in ((inscribed, 3), (corner, 2)):
        a, b = length / 2.0 - r, width / 2.0 - r
        discs += [(i, j, r) for i in np.linspace(-a, a, count) for j in np.linspace(-b, b, count)]
    return np.array(discs).T


def _column_discs(description: RobotDescription) -> Array:
    """(3, N) x, y and radius of discs in b around the arm's foot and its links up to the swivel."""
    discs, swivel, bTl = [], description.swivel, description.bTa
    last = 0 if swivel is None else swivel.joint + 1
    for link in range(last + 1):
        bTl = bTl * description.arm.joints[link - 1] if link else bTl
        for part in description.arm.collision[link]:
            circles = _circles(part.moved(bTl))
            if link == last and link > 0:  # it turns: parts off its axis sweep a ring
                x, y = bTl.translation[:2]
                circles = [(x, y, max(hypot(a - x, b - y) + r for a, b, r in circles))]
            discs += circles
    return np.array(discs or [(*description.bTa.translation[:2], 0.0)]).T  # without shapes


def _circles(part: Geom) -> list[tuple[float, float, float]]:
    """x, y and radius of circles around a capsule or a hull, seen from above."""
    R, p = part.pose.rotation, part.pose.translation[:2]
    if isinstance(part.shape, Hull):
        corners = part.shape.vertices @ R.T[:, :2] + p
        x, y = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
        return [(x, y, float(np.hypot(*(corners - [x, y]).T).max()))]
    along = R[:2, 2] * getattr(part.shape, "half_length", 0.0)
    radius = getattr(part.shape, "radius", 0.0)
    return [(*(p - along), radius), (*(p + along), radius)]
