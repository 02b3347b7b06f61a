"""Proximity queries: the pairs of shapes that are near, their distances and distance Jacobians.

A pair is measured again only when the motion since its last measurement could have brought it near
enough to matter.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf
from operator import sub
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Indices, Mask
from config.planar import ORIGIN, Pose2D, wrap
from config.poses import MapPose
from controller.collision.collision_model import CollisionModels, PairKind
from controller.collision.point_clearance import NearPoints, PointClearance
from controller.model import RobotModel
from controller.surroundings import OPEN_FLOOR, Surroundings

_AHEAD = 4.0
"""Periods: with the pairs that are due, those due within them are measured, which takes little more
time."""
_POINT_MARGIN = 0.01  # by which a surface may be nearer between two depth points [m]


class Distances(NamedTuple):
    """K pairs of shapes that are near each other."""

    d: Array  # (K,) between their surfaces [m]; negative if they overlap
    rows: Array  # (K, n) distance Jacobian: growth per velocity of every degree of freedom [m/rad]
    drift: Array  # (K,) growth by the motion of the obstacle itself [m/s]
    kind: Indices  # (K,) `PairKind`
    pair: Indices  # (K,) indices for `Proximity.pair_name`

    def without(self, kind: PairKind) -> Distances:
        """All pairs but those of one kind."""
        kept = self.kind != kind
        return Distances(*(values[kept] for values in self))

    def joined(self, others: Distances) -> Distances:
        """These and others."""
        return Distances(*(np.concatenate(both) for both in zip(self, others, strict=True)))


class Ranges(NamedTuple):
    """Distances below which pairs matter, by `PairKind`.

    For an approach speed v: stop + v delay + v² / 2 deceleration, at most `most`.
    """

    stop: float  # [m]
    delay: Array  # (kinds,) [s]
    deceleration: Array  # (kinds,) [m/s^2]
    most: Array  # (kinds,) [m]

    def of(self, kind: Indices) -> Callable[[Array], Array]:
        """For kinds (P,): the function from speeds (P,) [m/s] to distances that matter (P,) [m]."""
        delay, braking, most = self.delay[kind], 0.5 / self.deceleration[kind], self.most[kind]

        def within(speeds: Array) -> Array:
            needed = speeds * braking
            needed += delay
            needed *= speeds
            needed += self.stop
            return np.minimum(needed, most, out=needed)

        return within


class Proximity:
    """Tracks the distances of one robot from period to period; not thread-safe."""

    def __init__(
        self, model: RobotModel, ranges: Ranges, models: CollisionModels | None = None
    ) -> None:
        self._model = model
        self._models = models or CollisionModels(model)
        self._ranges = ranges
        axes = np.abs(model.description.base.axes)
        self._axes = np.array([axes[:2].max(axis=0), axes[2]]).T.tolist()
        """For every degree of freedom of the base, how far it moves and turns it."""
        nothing = np.zeros(0)
        self._none = Distances(
            nothing, np.zeros((0, model.n)), nothing, nothing.astype(int), nothing.astype(int)
        )
        self._here, self._q = ORIGIN, [0.0] * model.n_arm
        self._known = OPEN_FLOOR
        self._start()

    def _start(self) -> None:
        """Forget all distances, and take the shapes of the present surroundings."""
        self._collision = collision = self._models.around(self._known)
        pairs = collision.pairs
        self._moves = 1.0 * collision.masks[pairs.second] - collision.masks[pairs.first]
        """(P, n) 1 where only the second of a pair is moved, -1 where only the first is."""
        self._reach = collision.reach[pairs.first] * np.abs(self._moves)
        """(P, n) largest change of each distance per degree of freedom."""
        self._matters = self._ranges.of(pairs.kind)
        self._depth: PointClearance | None = None
        self._at_least: Array = np.full(len(pairs.first), -inf)
        """(P,) lower bounds of the distances [m]."""
        self._velocities = np.zeros((len(collision.masks), 3))  # (G, 3) of moving obstacles [m/s]
        self._centres = _centres(self._known)

    def update_shapes(self, surroundings: Surroundings) -> None:
        """Start anew with other surroundings; pairs without held or loose objects are kept."""
        known, self._known = self._known, surroundings
        if surroundings is known or surroundings.has_shapes_of(known):
            return
        at_least, permanent, centres = self._at_least, self._collision.permanent, self._centres
        self._start()
        if surroundings.stands_like(known):
            self._at_least[self._collision.permanent] = at_least[permanent]
            self._centres = centres

    def near(
        self,
        mTb: MapPose,
        q: Array,
        surroundings: Surroundings,
        fastest: Array,
        here: Pose2D | None = None,
        margin: float = 0.0,
    ) -> Distances:
        """All pairs that are near enough to matter.

        Args:
            mTb: base pose.
            q: (j,) joint positions [rad].
            surroundings: the obstacles.
            fastest: (n,) largest speed of every degree of freedom in this period.
            here: `mTb` on the floor, where it is known already.
            margin: by which pairs matter from farther away [m].
        """
        self.update_shapes(surroundings)
        collision = self._collision
        moved = self._motion(here or Pose2D.of(mTb), q)
        nearer = np.dot(self._reach, moved)
        self._at_least -= nearer
        speeds = np.dot(self._reach, fastest)
        if surroundings.moving:
            speeds += self._move_obstacles(surroundings)
        matters = self._matters(speeds)
        if margin > 0.0:
            matters += margin
        (some,) = (self._at_least <= matters).nonzero()
        if len(some):
            (some,) = (self._at_least - _AHEAD * nearer <= matters).nonzero()
        points, cloud = None, surroundings.depth_points
        if cloud is not None:
            depth = self._depth = self._depth or PointClearance(collision, self._ranges.of)
            points = depth.due(cloud, np.array([moved, fastest]).T)
        if not len(some) and points is None:
            return self._none
        collision.place(mTb, q, [one.geom for one in surroundings.moving])
        near = self._measure(some, matters[some]) if len(some) else self._none
        return near if points is None else near.joined(self._points(depth.measure(points)))

    def _measure(self, some: Indices, matters: Array) -> Distances:
        collision, pairs = self._collision, self._collision.pairs
        self._at_least[some] = d = collision.measure(some.tolist())
        (near,) = (d <= matters).nonzero()
        if not len(near):
            return self._none
        some = some[near]
        lines = collision.lines(some.tolist())
        drift = np.zeros(len(some))
        if collision.moving:
            drift = (lines[:, :3] * self._velocities[pairs.second[some]]).sum(axis=1)
        rows = (lines @ collision.jacobian()) * self._moves[some]
        return Distances(d[near], rows, drift, pairs.kind[some], some)

    def _points(self, points: NearPoints) -> Distances:
        """Distances to depth points; their indices follow those of the pairs."""
        collision = self._collision
        return Distances(
            points.d - _POINT_MARGIN,
            -(points.lines @ collision.jacobian()) * collision.masks[points.shape],
            np.zeros(len(points.d)),
            points.kind,
            len(collision.pairs.first) + points.shape,
        )

    def is_mapped(self, pairs: Indices) -> Mask:
        """(K,) which pairs (K,) are with a fixture of the map."""
        mapped = self._collision.mapped
        return mapped.take(pairs, mode="clip") & (pairs < len(mapped))

    def pair_name(self, pair: int) -> str:
        """The names of the shapes of a pair."""
        count = len(self._collision.pairs.first)
        if pair >= count:
            return f"{self._collision.names[pair - count]} and what the camera sees"
        return self._collision.pair_name(pair)

    def pair_points(self, pair: int) -> tuple[Array, Array] | None:
        """The nearest points (3,) of a pair when last measured; None for depth points."""
        return self._collision.nearest_points(pair) if pair < len(self._moves) else None

    def _motion(self, here: Pose2D, q: Array) -> Array:
        """(n,) motion of every degree of freedom since the last query."""
        gone = hypot(here.x - self._here.x, here.y - self._here.y)
        turned, joints = abs(wrap(here.heading - self._here.heading)), q.tolist()
        moved = [gone * goes + turned * turns for goes, turns in self._axes]
        moved += map(abs, map(sub, joints, self._q))
        self._here, self._q = here, joints
        return np.array(moved)

    def _move_obstacles(self, surroundings: Surroundings) -> Array:
        """Subtract the motion of obstacles from the distances; their speeds (P,) [m/s]."""
        moving, second = self._collision.moving, self._collision.pairs.second
        centres, steps = _centres(surroundings), np.zeros(len(self._velocities))
        steps[moving] = np.linalg.norm(centres - self._centres, axis=1)
        self._at_least -= steps[second]
        self._centres = centres
        self._velocities[moving] = [one.velocity for one in surroundings.moving]
        speeds: Array = np.linalg.norm(self._velocities, axis=1)[second]
        return speeds


def _centres(surroundings: Surroundings) -> Array:
    """(M, 3) centres of moving obstacles on the map [m]."""
    return np.array([one.geom.pose.translation for one in surroundings.moving]).reshape(-1, 3)
