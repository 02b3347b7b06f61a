"""Which shapes are near each other, and how fast their distances grow.

A pair is measured again only when the motion since it was last measured could have brought it so
near that it matters.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.collision.collision_model import CollisionModels, PairKind
from controller.collision.point_clearance import NearPoints, PointClearance
from controller.command import Array
from controller.floor import Pose2D, wrap
from controller.model import RobotModel
from controller.surroundings import OPEN_FLOOR, Surroundings

_BETWEEN = 0.01
"""What is seen is known at points that are up to 3 cm apart; between them it may come this much
nearer [m]."""


class Distances(NamedTuple):
    """K pairs of shapes that are near each other."""

    d: Array
    """(K,) between their surfaces [m]; negative if they overlap."""
    rows: Array
    """(K, n) how fast the distance grows per velocity of every degree of freedom [m/rad]."""
    drift: Array
    """(K,) how fast it grows by the motion of the obstacle itself [m/s]."""
    kind: npt.NDArray[np.int64]
    """(K,) `PairKind`."""
    pair: npt.NDArray[np.int64]
    """(K,) numbers for `Proximity.pair_name`."""

    def without(self, kind: PairKind) -> Distances:
        """All pairs but those of one kind."""
        kept = self.kind != kind
        return Distances(*(values[kept] for values in self))

    def joined(self, others: Distances) -> Distances:
        """These and others."""
        return Distances(*(np.concatenate(both) for both in zip(self, others, strict=True)))


class Ranges(NamedTuple):
    """How near to each other pairs of each `PairKind` must be to matter.

    For pairs that may approach at a speed v: stop + v delay + v² / 2 deceleration, at most `most`.
    """

    stop: float
    """[m]."""
    delay: Array
    """(kinds,) [s]."""
    deceleration: Array
    """(kinds,) [m/s^2]."""
    most: Array
    """(kinds,) [m]."""

    def of(self, kind: npt.NDArray[np.int64]) -> Callable[[Array], Array]:
        """For (P,) kinds: from speeds (P,) [m/s] to the distances (P,) that matter [m]."""
        delay, braking, most = self.delay[kind], 0.5 / self.deceleration[kind], self.most[kind]

        def within(speeds: Array) -> Array:
            needed = self.stop + speeds * (delay + speeds * braking)
            return np.asarray(np.minimum(needed, most))

        return within


class Proximity:
    """Keeps track of the distances of one robot.

    Not to be shared between threads.

    Args:
        model: the robot.
        ranges: when a pair matters.
        models: where collision models are made; None makes them for this one alone.
    """

    def __init__(
        self, model: RobotModel, ranges: Ranges, models: CollisionModels | None = None
    ) -> None:
        self._model = model
        self._models = models or CollisionModels(model)
        self._ranges = ranges
        axes = np.abs(model.description.base.axes)
        self._goes, self._turns = axes[:2].max(axis=0), axes[2]
        self._motion = np.zeros((model.n, 2))
        """How far every degree of freedom has moved at most since pairs were last looked at, and
        its largest speed."""
        nothing = np.zeros(0)
        self._none = Distances(
            nothing, np.zeros((0, model.n)), nothing, nothing.astype(int), nothing.astype(int)
        )
        self._here, self._q = Pose2D(0.0, 0.0, 0.0), np.zeros(model.n - model.n_base)
        self._known = OPEN_FLOOR
        self._start()

    def _start(self) -> None:
        """Know no distance, among the shapes that stand around now."""
        self._collision = collision = self._models.around(self._known)
        pairs = collision.pairs
        self._moves = 1.0 * collision.masks[pairs.second] - collision.masks[pairs.first]
        """(P, n) which degrees of freedom move the second of each pair (1), or the first (-1)."""
        self._reach = collision.reach[pairs.first] * np.abs(self._moves)
        """(P, n) the most by which a degree of freedom changes each distance."""
        self._matters = self._ranges.of(pairs.kind)
        self._feelers: PointClearance | None = None
        self._at_least: Array = np.full(len(pairs.first), -inf)
        """(P,) least distance that each pair may have [m]."""
        self._velocities = np.zeros((len(collision.masks), 3))
        """(G, 3) of the shapes that move by themselves, in the world [m/s]."""
        self._centres = _centres(self._known)

    def heed(self, surroundings: Surroundings) -> None:
        """Start anew where other things stand around; or only with what is loose or held."""
        known, self._known = self._known, surroundings
        if surroundings.has_shapes_of(known):
            return
        at_least, lasting, centres = self._at_least, self._collision.lasts, self._centres
        self._start()
        if surroundings.stands_like(known):
            self._at_least[self._collision.lasts] = at_least[lasting]
            self._centres = centres

    def near(
        self,
        wTb: SE3,
        q: Array,
        surroundings: Surroundings,
        fastest: Array,
        here: Pose2D | None = None,
    ) -> Distances:
        """All pairs that are so near to each other that they matter.

        Args:
            wTb: base pose.
            q: (7,) joint positions [rad].
            surroundings: what stands around.
            fastest: (n,) largest speed of every degree of freedom in this period.
            here: base pose on the floor, where that is known already.
        """
        self.heed(surroundings)
        collision = self._collision
        self._note_motion(here or Pose2D.of(wTb), q)
        cloud = surroundings.depth_points
        self._motion[:, 1] = fastest
        changes = self._reach @ self._motion
        self._at_least -= changes[:, 0]
        speeds = changes[:, 1]
        if surroundings.moving:
            speeds = speeds + self._move_obstacles(surroundings)
        matters = self._matters(speeds)
        (some,) = np.nonzero(self._at_least <= matters)
        felt = None
        if cloud is not None:
            feelers = self._feelers = self._feelers or PointClearance(collision)
            felt = feelers.due(cloud, self._motion, self._ranges.of(feelers.kind))
        self._motion[:, 0] = 0.0
        if not len(some) and felt is None:
            return self._none
        collision.place(wTb, q, [one.geom for one in surroundings.moving])
        near = self._measure(some, matters[some])
        return near if felt is None else near.joined(self._points(feelers.feel(felt)))

    def _measure(self, some: npt.NDArray[np.int64], matters: Array) -> Distances:
        """Those of some pairs that are so near that they matter."""
        collision, pairs = self._collision, self._collision.pairs
        results = [collision.measure(pair) for pair in some.tolist()]
        d = np.array([result.min_distance for result in results])
        self._at_least[some] = d
        (near,) = np.nonzero(d <= matters)
        if not len(near):
            return self._none
        some = some[near]
        lines = np.array([_line(results[k]) for k in near.tolist()])
        return Distances(
            d[near],
            (lines @ collision.jacobian()) * self._moves[some],
            (lines[:, :3] * self._velocities[pairs.second[some]]).sum(axis=1),
            pairs.kind[some],
            some,
        )

    def _points(self, felt: NearPoints) -> Distances:
        """The same of points that were seen; their numbers go on after those of the pairs."""
        collision = self._collision
        return Distances(
            felt.d - _BETWEEN,
            -(felt.lines @ collision.jacobian()) * collision.masks[felt.shape],
            np.zeros(len(felt.d)),
            felt.kind,
            len(collision.pairs.first) + felt.shape,
        )

    def pair_name(self, pair: int) -> str:
        """What meets what, for people."""
        count = len(self._collision.pairs.first)
        if pair >= count:
            return f"{self._collision.names[pair - count]} and what the camera sees"
        return self._collision.pair_name(pair)

    def pair_points(self, pair: int) -> tuple[Array, Array] | None:
        """Where two shapes are nearest to each other, as last measured; None for what is seen."""
        return self._collision.nearest_points(pair) if pair < len(self._moves) else None

    def _note_motion(self, here: Pose2D, q: Array) -> None:
        """Note by how much every degree of freedom may have moved."""
        gone = hypot(here.x - self._here.x, here.y - self._here.y)
        turned = abs(wrap(here.heading - self._here.heading))
        n_base, moved = self._model.n_base, self._motion[:, 0]
        moved[:n_base] += gone * self._goes + turned * self._turns
        moved[n_base:] += np.abs(q - self._q)
        self._here, self._q = here, q.copy()

    def _move_obstacles(self, surroundings: Surroundings) -> Array:
        """Take off the distances how far obstacles have moved; returns their speeds (P,) [m/s]."""
        moving, second = self._collision.moving, self._collision.pairs.second
        centres, steps = _centres(surroundings), np.zeros(len(self._velocities))
        steps[moving] = np.linalg.norm(centres - self._centres, axis=1)
        self._at_least -= steps[second]
        self._centres = centres
        self._velocities[moving] = [one.velocity for one in surroundings.moving]
        speeds: Array = np.linalg.norm(self._velocities, axis=1)[second]
        return speeds


def _line(result: Any) -> tuple[float, ...]:
    """The normal at the nearest points as a line: direction and moment about the origin."""
    nx, ny, nz = result.normal.tolist()
    x, y, z = result.getNearestPoint1().tolist()
    return nx, ny, nz, y * nz - z * ny, z * nx - x * nz, x * ny - y * nx


def _centres(surroundings: Surroundings) -> Array:
    """(M, 3) of what moves by itself, in the world [m]."""
    return np.array([one.geom.pose.translation for one in surroundings.moving]).reshape(-1, 3)
