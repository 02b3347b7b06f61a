"""The pose at which measured points lie on the surfaces of the map, by Gauss-Newton.

Unknown at once are the pose of the base, the errors that all points of a sensor share, and how far
each piece of furniture stands from its place. Signed distances have the Geman-McClure loss, whose
scale shrinks from what the prior allows to the noise of the points (graduated non-convexity, Yang
et al. 2020). What is not the pose is marginalised (Schur complement): a flat wall says nothing
along itself, and a thousand points of a camera no more than its mounting does.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import radians
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Indices, Mask
from config.planar import act
from perception.registration.sensors import Cloud
from perception.registration.surfaces import Surfaces

_CANDIDATES = 3
"""Shapes that are tried for each point: those nearest to it at the prior."""
_SPREADS = (2.0, 0.8, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0)
"""By how many standard deviations of the prior the loss is widened, iteration by iteration."""
_NARROW = 0.01
"""Widening by less than this is left out [m]."""
_SETTLED = 2e-4
"""A step smaller than this is the last [m, rad]."""
_STRAINED = 11.3
"""A displacement whose squared Mahalanobis distance is larger is doubted (chi-squared, 1 %)."""
_ERRORS = 7
"""Of a sensor: offset (3), turn (3), scale."""
LOSS_SCALE = 3.0
"""Standard deviations of a point at which its weight is a quarter."""
_IN_PLACE = (0.002, 0.002, radians(0.1))
"""Standard deviations of where furniture stands in the map: x, y [m], heading [rad]."""
DISPLACED = (0.06, 0.06, radians(2.5))
"""The same of a piece that was moved."""
_REACH = 0.15
"""A point farther than this from all surfaces is not used, beyond what the prior allows [m]."""
PRICE = 25.0
"""A piece counts as moved if that lowers the cost, a squared Mahalanobis distance, by this."""
SUPPORT = 12
"""Points on a piece of furniture without which nothing is said of it."""


class Tries(NamedTuple):
    """Which shapes each point may lie on."""

    shapes: Indices
    """(N, C)."""
    columns: Indices
    """(N, C) of the pieces that they belong to."""


class Match(NamedTuple):
    """Each point on its shape."""

    residuals: Array
    """(N,) signed distances [m]."""
    J: Array
    """(N, n) their derivatives."""
    seen: Mask
    """(N,) whether a point met the side of its shape that the sensor can see."""
    points: Array
    """(N, 3) in the map [m]."""
    tries: Tries
    """The shape of each point, C = 1."""

    @property
    def column(self) -> Indices:
        """(N,) the piece of each point."""
        return self.tries.columns[:, 0]


class Solution(NamedTuple):
    """The unknowns at the optimum."""

    loose: frozenset[int]
    """Columns of the pieces that may have been moved."""
    x: Array
    """(n,) the unknowns."""
    information: Array
    """(n, n) of data and priors."""
    data: Array
    """(n, n) of data."""
    cost: float
    """Squared Mahalanobis distance of data and priors, and the price of the loose pieces."""
    losses: Array
    """(N,) part of each point in the cost."""
    match: Match


class Problem:
    """Points near the surfaces of a map, and what is known before they are matched."""

    def __init__(
        self,
        surfaces: Surfaces,
        clouds: Sequence[Cloud],
        prior: Array,
        covariance: Array,
    ) -> None:
        """Choose the points that can lie on a surface; arguments as of `register`."""
        self.surfaces, self._prior = surfaces, prior
        self._prior_information = np.linalg.inv(covariance)
        self._errors = [cloud.errors for cloud in clouds]
        points = np.concatenate([np.zeros((0, 3)), *(cloud.points for cloud in clouds)])
        sensor = np.repeat(np.arange(len(clouds)), [len(cloud.points) for cloud in clouds])
        across = np.hypot(points[:, 0], points[:, 1])
        spread = np.sqrt(np.linalg.eigvalsh(covariance[:2, :2])[1] + covariance[2, 2] * across**2)
        nearest, away = surfaces.nearest(_moved(points, prior), _CANDIDATES)
        (kept,) = np.nonzero(away < _REACH + 3.0 * spread)
        self._points, shapes, self._spread = points[kept], nearest[kept], spread[kept]
        self._eyes = np.array([cloud.eye for cloud in clouds]).reshape(-1, 3)
        sensor = sensor[kept]
        ends = np.searchsorted(sensor, np.arange(len(clouds) + 1)).tolist()
        self._slices = [slice(a, b) for a, b in pairwise(ends)]
        self._sensor = sensor
        ranges = np.linalg.norm(self._points - self._eyes[sensor], axis=1)
        noise = np.array([[e.noise, e.noise_growth] for e in self._errors]).reshape(-1, 2)[sensor]
        self._variance = noise[:, 0] ** 2 + (noise[:, 1] * ranges**2) ** 2
        self.pieces, columns = np.unique(surfaces.piece[shapes], return_inverse=True)
        """(K,) the pieces in sight; columns of unknowns are numbered like them."""
        self._tries = Tries(shapes, columns.reshape(shapes.shape))
        self.centres = surfaces.centres[self.pieces]
        """(K, 2) about which they are said to turn, in the map [m]."""
        self._first = 3 + _ERRORS * len(clouds)
        self.n = self._first + 3 * len(self.pieces)
        self._start = self.matched(np.zeros(self.n))

    def suspects(self, solution: Solution) -> set[int]:
        """Columns of the furniture in sight that does not lie on its surfaces.

        By chi-squared of its displacement, and of the points that one sensor has on it.
        """
        strained = solution.x[self._first :].reshape(-1, 3) / self._deviations(solution.loose)
        suspects = set(np.flatnonzero((strained**2).sum(axis=1) > _STRAINED).tolist())
        for some in self._slices:
            column, losses = solution.match.column[some], solution.losses[some]
            counts = np.bincount(column, minlength=len(self.pieces))
            sums = np.bincount(column, losses, minlength=len(self.pieces))
            suspects |= set(np.flatnonzero(sums > counts + 4.0 * np.sqrt(2.0 * counts)).tolist())
        return suspects

    def name(self, column: int) -> str:
        """Of a piece in sight."""
        return self.surfaces.names[int(self.pieces[column])]

    def displacement(self, column: int) -> slice:
        """The unknowns of a piece."""
        return slice(self._first + 3 * column, self._first + 3 * column + 3)

    def solve(self, loose: frozenset[int] = frozenset()) -> Solution:
        """The optimum if the pieces of these columns may have been moved, from the prior on."""
        x, known = np.zeros(self.n), self._known(loose)
        free = np.zeros(len(self.pieces))
        free[list(loose)] = DISPLACED[0]
        tries = self._tries
        widest = max(self._spread.max(initial=0.0), free.max(initial=0.0))
        for spread in _SPREADS:
            if 0.0 < spread * widest < _NARROW:
                continue
            match = self._start if not x.any() else self.matched(x, tries)
            if spread == 0.0:
                tries = match.tries
            widening = spread**2 * (self._spread**2 + free[match.column] ** 2)
            J, r = match.J, match.residuals
            weighted = self._weights(match, widening)[:, None] * J
            data = J.T @ weighted
            step = np.linalg.solve(data + known, r @ weighted + known @ x)
            x = x - step
            if spread == 0.0 and np.abs(step[:3]).max() < _SETTLED:
                break
        match = self.matched(x, tries)
        data = match.J.T @ (self._weights(match)[:, None] * match.J)
        squares = np.where(match.seen, match.residuals**2 / self._variance, np.inf)
        most = LOSS_SCALE**2
        losses = most / (1.0 + most / np.maximum(squares, 1e-12))
        cost = float(losses.sum() + x @ known @ x) + PRICE * len(loose)
        return Solution(loose, x, data + known, data, cost, losses, match)

    def marginal(self, solution: Solution, times: float = 1.0) -> Array:
        """(3, 3) information on the pose of the data alone, if they were measured `times` over."""
        known = self._known(solution.loose)
        known[:3, :3] = 0.0
        whole = times * solution.data + known
        rest = np.linalg.solve(whole[3:, 3:], whole[3:, :3])
        information: Array = whole[:3, :3] - whole[:3, 3:] @ rest
        values, vectors = np.linalg.eigh(0.5 * (information + information.T))
        information = (vectors * np.maximum(values, 0.0)) @ vectors.T
        return information

    def _known(self, loose: frozenset[int]) -> Array:
        """(n, n) information of the priors."""
        errors = [[*[e.offset] * 3, *[e.turn] * 3, e.scale] for e in self._errors]
        places = self._deviations(loose)
        deviations = np.concatenate([np.zeros(0), *errors, places.reshape(-1)])
        known = np.zeros((self.n, self.n))
        known[:3, :3] = self._prior_information
        np.fill_diagonal(known[3:, 3:], deviations**-2.0)
        return known

    def _deviations(self, loose: frozenset[int]) -> Array:
        """(K, 3) standard deviations of where the pieces stand."""
        places = np.tile(_IN_PLACE, (len(self.pieces), 1))
        places[list(loose)] = DISPLACED
        return places

    def _weights(self, match: Match, widening: Array | float = 0.0) -> Array:
        """(N,) of the squared residuals: Geman-McClure over the variance [1/m²]."""
        scale = LOSS_SCALE**2 * self._variance + widening
        weights: Array = match.seen / (1.0 + match.residuals**2 / scale) ** 2 / self._variance
        return weights

    def matched(self, x: Array, tries: Tries | None = None) -> Match:
        """Each point on the nearest of the shapes that are tried, if the unknowns are x (n,)."""
        tries = tries or self._tries
        pose = self._prior + x[:3]
        p, eyes = _moved(self._points, pose), _moved(self._eyes, pose).take(self._sensor, axis=0)
        count, width = tries.shapes.shape
        ray = p - eyes
        errors = x[3 : self._first].reshape(-1, _ERRORS).take(self._sensor, axis=0)
        p += errors[:, :3] + errors[:, 6:] * ray + _cross(errors[:, 3:6], ray)
        # Where the point would lie if the piece stood in its place.
        columns = tries.columns.reshape(-1)
        place = x[self._first :].reshape(-1, 3)
        c, s = (f(place[:, 2]).take(columns) for f in (np.cos, np.sin))
        centre = self.centres.take(columns, axis=0)
        beside = np.repeat(p, width, axis=0)
        flat = beside[:, :2] - centre - place[:, :2].take(columns, axis=0)
        beside[:, 0] = centre[:, 0] + c * flat[:, 0] + s * flat[:, 1]
        beside[:, 1] = centre[:, 1] - s * flat[:, 0] + c * flat[:, 1]
        from_eyes = np.repeat(eyes, width, axis=0)
        d, n, seen = self.surfaces.distances(beside, tries.shapes.reshape(-1), from_eyes)
        rows = np.arange(count)
        best = np.abs(d).reshape(count, width).argmin(axis=1)
        chosen = rows * width + best
        n, column = n[chosen], columns[chosen]
        J = self._jacobian(p, ray, n, column, pose)
        few = Tries(tries.shapes[rows, best][:, None], column[:, None])
        return Match(d[chosen], J, seen[chosen], p, few)

    def _jacobian(self, p: Array, ray: Array, n: Array, column: Indices, pose: Array) -> Array:
        """(N, n) of the distances of points p, seen along rays, from surfaces with normals n."""
        J = np.zeros((len(p), self.n))
        J[:, :3] = _planar_rows(n, p[:, :2] - pose[:2])
        of_errors = _columns(*n.T, *_cross(ray, n).T, np.einsum("ij,ij->i", n, ray))
        for number, some in enumerate(self._slices):
            J[some, 3 + _ERRORS * number : 3 + _ERRORS * (number + 1)] = of_errors[some]
        of_piece = self._first + 3 * column[:, None] + np.arange(3)
        J[np.arange(len(p))[:, None], of_piece] = -_planar_rows(n, p[:, :2] - self.centres[column])
        return J


def _cross(a: Array, b: Array) -> Array:
    """(N, 3) cross products."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return _columns(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


def _planar_rows(normals: Array, arms: Array) -> Array:
    """(N, 3) growth of distances per planar motion of points at `arms` (N, 2) from the centre."""
    turning = normals[:, 1] * arms[:, 0] - normals[:, 0] * arms[:, 1]
    return _columns(normals[:, 0], normals[:, 1], turning)


def _moved(points: Array, aTb: Array) -> Array:
    """Points (N, 3) of b in a, for a pose on the floor (3,)."""
    return _columns(*act(aTb, points[:, 0], points[:, 1]), points[:, 2])


def _columns(*parts: Array) -> Array:
    """(N, k) of k arrays (N,): `np.stack` takes several times as long for so few points."""
    table = np.empty((len(parts[0]), len(parts)))
    for number, part in enumerate(parts):
        table[:, number] = part
    return table
