"""Which shapes are near each other, and how fast their distances grow.

A pair is measured again only when the motion since it was last measured could have brought it so
near that it matters.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.base_drive import Pose2D, wrap
from controller.collision_model import CollisionModel, PairKind
from controller.command import Array
from controller.model import RobotModel
from controller.surroundings import Surroundings


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


Range: TypeAlias = Callable[[Array], Array]
"""Distances (P,) [m] for speeds (P,) [m/s]."""


class Proximity:
    """Keeps track of the distances of one robot.

    Not to be shared between threads.

    Args:
        model: the robot.
    """

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._known: Surroundings | None = None

    def near(
        self, wTb: SE3, q: Array, surroundings: Surroundings, fastest: Array, within: Range
    ) -> Distances:
        """All pairs that are so near to each other that they matter.

        Args:
            wTb: base pose.
            q: (7,) joint positions [rad].
            surroundings: what stands around.
            fastest: (n,) largest speed of every degree of freedom in this period.
            within: the distance that matters for pairs that approach at a speed.
        """
        self._heed(surroundings)
        collision, pairs = self._collision, self._collision.pairs
        self._forget(Pose2D.of(wTb), q, surroundings)
        matters = within(self._reach @ fastest + self._obstacle_speeds)
        (some,) = np.nonzero(self._at_least <= matters)
        collision.place(wTb, q, [one.geom for one in surroundings.moving])
        results = [collision.measure(pair) for pair in some.tolist()]
        d = np.array([result.min_distance for result in results])
        self._at_least[some] = d
        (near,) = np.nonzero(d <= matters[some])
        some, d = some[near], d[near]
        normals = np.array([results[k].normal for k in near]).reshape(-1, 3)
        points = np.array([results[k].getNearestPoint1() for k in near]).reshape(-1, 3)
        lines = np.concatenate([normals, np.cross(points, normals)], axis=1)
        moved = collision.masks[pairs.second[some]].astype(float)
        moved -= collision.masks[pairs.first[some]]
        return Distances(
            d,
            (lines @ collision.jacobian()) * moved,
            (normals * self._velocities[pairs.second[some]]).sum(axis=1),
            pairs.kind[some],
            some,
        )

    def pair_name(self, pair: int) -> str:
        """What meets what, for people."""
        return self._collision.pair_name(pair)

    def _heed(self, surroundings: Surroundings) -> None:
        """Start anew where other things stand around, or the hand holds something else."""
        known, self._known = self._known, surroundings
        if (
            known is not None
            and known.fixtures is surroundings.fixtures
            and known.held is surroundings.held
            and [one.geom.shape for one in known.moving]
            == [one.geom.shape for one in surroundings.moving]
        ):
            return
        self._collision = collision = CollisionModel(self._model, surroundings)
        pairs = collision.pairs
        between = collision.masks[pairs.first] ^ collision.masks[pairs.second]
        self._reach = collision.reach[pairs.first] * between
        """(P, n) the most by which a degree of freedom changes each distance."""
        self._at_least = np.full(len(pairs.first), -np.inf)
        """(P,) least distance that each pair may have [m]."""
        self._velocities = np.zeros((len(collision.masks), 3))
        """(G, 3) of the shapes that move by themselves, in the world [m/s]."""
        self._obstacle_speeds = np.zeros(len(pairs.first))
        """(P,) how fast the second of each pair moves by itself [m/s]."""
        self._centres = _centres(surroundings)
        self._here, self._q = Pose2D(0.0, 0.0, 0.0), np.zeros(self._model.n - self._model.n_base)

    def _forget(self, here: Pose2D, q: Array, surroundings: Surroundings) -> None:
        """Take off every distance what the motion since the last call may have taken."""
        axes = self._model.description.base.axes
        gone = hypot(here.x - self._here.x, here.y - self._here.y)
        turned = abs(wrap(here.heading - self._here.heading))
        base = gone * (axes[:2] != 0.0).any(axis=0) + turned * np.abs(axes[2])
        self._at_least -= self._reach @ np.concatenate([base, np.abs(q - self._q)])
        self._here, self._q = here, q.copy()
        if not surroundings.moving:
            return
        moving, second = self._collision.moving, self._collision.pairs.second
        centres, steps = _centres(surroundings), np.zeros(len(self._velocities))
        steps[moving] = np.linalg.norm(centres - self._centres, axis=1)
        self._at_least -= steps[second]
        self._velocities[moving] = [one.velocity for one in surroundings.moving]
        self._obstacle_speeds = np.linalg.norm(self._velocities, axis=1)[second]
        self._centres = centres


def _centres(surroundings: Surroundings) -> Array:
    """(M, 3) of what moves by itself, in the world [m]."""
    return np.array([one.geom.pose.translation for one in surroundings.moving]).reshape(-1, 3)
