"""The shapes of the robot and of what stands around it, and the distances between them.

Coal measures. Robot and surroundings are in the world; the chain's first placement is the base's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum
from itertools import product
from math import hypot
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pinocchio import SE3

from controller.collision.robot_shapes import Part, robot_parts, upright_edges
from controller.command import Array
from controller.model import RobotModel
from controller.surroundings import OPEN_FLOOR, Surroundings
from robots import Geom, bounding_radius, coal_geometry, half_extents


class PairKind(IntEnum):
    """What meets what."""

    SELF = 0
    """The arm meets the robot itself, or the floor."""
    BASE = 1
    """The base meets what stands around."""
    ARM = 2
    """The arm meets what stands around."""
    HAND = 3
    """Hand, fingers and what they hold meet what stands around."""
    PALM = 4
    """The palm does, which has nothing to touch even where the fingers close."""
    BASE_MOVING = 5
    """The base meets what moves by itself."""
    ARM_MOVING = 6
    """Arm or hand meet what moves by itself."""
    AHEAD = 7
    """The base would meet later what moves by itself."""


class Pairs(NamedTuple):
    """P pairs of shapes that can meet; the robot is the first of each."""

    first: npt.NDArray[np.int64]
    """(P,) numbers of shapes."""
    second: npt.NDArray[np.int64]
    """(P,)."""
    kind: npt.NDArray[np.int64]
    """(P,) `PairKind`."""


class Body(NamedTuple):
    """A shape of the robot that can meet what stands around."""

    number: int
    """Of the shape."""
    geom: Geom
    """Its pose is not that of the shape in the world."""
    kind: PairKind
    """With what does not move."""


class CollisionModel:
    """One robot in one place.

    Not to be shared between threads: Pinocchio's and Coal's workspaces are reused.

    Args:
        model: the robot.
        surroundings: what stands around it.
    """

    def __init__(self, model: RobotModel, surroundings: Surroundings = OPEN_FLOOR) -> None:
        self._model = model
        self._chain = model.chain.copy()
        self._data = self._chain.createData()
        self._shapes = pin.GeometryModel()
        self._moves: list[int] = []
        """How many degrees of freedom move each shape: the first ones, base first."""
        self._radius: list[float] = []
        self._half: list[Array] = []
        """Of the boxes around the shapes [m]."""
        self.names: list[str] = []
        """Of the shapes, for people."""
        parts = robot_parts(model, surroundings.held)
        numbers = {name: [self._add(name, p) for p in some] for name, some in parts.items()}
        self.bodies = [
            # What was seen may be what is grasped, which comes up to the palm.
            Body(number, part.geom, PairKind.HAND if name == "palm" else _kinds(name)[0])
            for name, some in parts.items()
            if name != "floor"
            for number, part in zip(numbers[name], some, strict=True)
        ]
        self.fixed = [self._add_still(one) for one in surroundings.fixtures]
        """Numbers of the fixtures, in their order."""
        self.moving = [self._add_still(one.geom) for one in surroundings.moving]
        edges = [
            self._add_still(edge) for one in surroundings.fixtures for edge in upright_edges(one)
        ]
        loose = [self._add_still(one) for one in surroundings.loose]
        self.pairs = pairs = self._pair(numbers, edges, loose)
        self.lasts = ~(np.isin(pairs.first, numbers["held"]) | np.isin(pairs.second, loose))
        """(P,) whether neither is held or loose: those pairs are the same, in the same order, as
        long as the same fixtures stand around."""
        self._results = pin.GeometryData(self._shapes)
        self.reach = self._reach()
        """(G, n) the most by which a degree of freedom moves any point of a shape [m/rad]."""
        self.masks = np.arange(model.n) < np.array(self._moves)[:, None]
        """(G, n) whether it moves the shape at all."""

    def place(self, wTb: SE3, q: Array, moving: Sequence[Geom] | None = None) -> None:
        """Put the robot, and what moves by itself, where they are.

        Args:
            wTb: base pose.
            q: (7,) joint positions [rad].
            moving: what moves by itself, in the order of the surroundings; None leaves it.
        """
        for shape, geom in zip(self.moving, moving, strict=True) if moving else ():
            self._shapes.geometryObjects[shape].placement = geom.pose
        self._chain.jointPlacements[1] = wTb
        self._q = self._model.joints(q)
        pin.updateGeometryPlacements(self._chain, self._data, self._shapes, self._results, self._q)

    def measure(self, pair: int) -> Any:
        """Coal's result for one pair: distance [m], nearest points, normal from first to second."""
        return pin.computeDistance(self._shapes, self._results, pair)

    def nearest_points(self, pair: int) -> tuple[Array, Array]:
        """Where the shapes of a pair were nearest to each other when it was last measured, (3,)."""
        result = self._results.distanceResults[pair]
        return result.getNearestPoint1().copy(), result.getNearestPoint2().copy()

    def poses(self, shapes: npt.NDArray[np.int64]) -> tuple[Array, Array]:
        """Rotations (S, 3, 3) and origins (S, 3) of shapes in the world."""
        placed = [self._results.oMg[shape] for shape in shapes.tolist()]
        return np.array([one.rotation for one in placed]), np.array([p.translation for p in placed])

    def ball(self, shape: int) -> tuple[Array, float]:
        """Centre (3,) and radius of the ball around a shape, where it was placed last [m]."""
        return self._results.oMg[shape].translation, self._radius[shape]

    def jacobian(self) -> Array:
        """(6, n) screws of the joints in the world, linear first."""
        pin.computeJointJacobians(self._chain, self._data, self._q)
        J: Array = self._data.J
        return J

    def clearance(self, q: Array, wTb: SE3 | None = None) -> float:
        """Smallest distance of the robot to itself, the floor and what does not move [m].

        Args:
            q: (7,) joint positions [rad].
            wTb: base pose; the origin without it.
        """
        self._chain.jointPlacements[1] = wTb or SE3.Identity()
        nearest = pin.computeDistances(
            self._chain, self._data, self._shapes, self._results, self._model.joints(q)
        )
        return float(self._results.distanceResults[nearest].min_distance)

    def contact_test(
        self, wTb: SE3, pairs: npt.NDArray[np.int64], margins: Array
    ) -> Callable[[Array], bool]:
        """Whether some pairs come nearer than their margins [m] at q (7,), the base at `wTb`."""
        results = pin.GeometryData(self._shapes)
        results.deactivateAllCollisionPairs()
        for pair, margin in zip(pairs.tolist(), margins.tolist(), strict=True):
            results.activateCollisionPair(pair)
            results.collisionRequests[pair].security_margin = margin

        def touches(q: Array) -> bool:
            self._chain.jointPlacements[1] = wTb
            joints = self._model.joints(q)
            return bool(
                pin.computeCollisions(self._chain, self._data, self._shapes, results, joints, True)
            )

        return touches

    def pair_name(self, pair: int) -> str:
        """What meets what, for people."""
        pairs = self.pairs
        return f"{self.names[pairs.first[pair]]} and {self.names[pairs.second[pair]]}"

    def _add(self, name: str, part: Part) -> int:
        n_base = self._model.n_base
        joint = n_base + max(part.link, 0)
        return self._put(joint, part.geom, name, joint)

    def _add_still(self, geom: Geom) -> int:
        return self._put(0, geom, geom.name, 0)

    def _put(self, joint: int, geom: Geom, name: str, moved_by: int) -> int:
        self._moves.append(moved_by)
        self._radius.append(bounding_radius(geom.shape))
        self._half.append(np.array(half_extents(geom.shape)))
        self.names.append(name)
        shape = coal_geometry(geom.shape)
        unique = f"{name}_{self._shapes.ngeoms}"
        return int(
            self._shapes.addGeometryObject(pin.GeometryObject(unique, joint, 0, geom.pose, shape))
        )

    def _pair(self, numbers: dict[str, list[int]], edges: list[int], loose: list[int]) -> Pairs:
        """All pairs that can meet: of the robot with itself, and of it with everything else."""
        found: list[tuple[int, int, PairKind]] = []
        aliases = {"hand": ("hand", "camera", "held")}
        for one, other in self._model.description.arm.may_touch:
            seconds = aliases.get(other, (other,))
            if one == "floor" and other == "hand":
                seconds = (*seconds, "palm")  # the capsules around the hand leave its corners free
            for second in seconds:
                for a, b in product(numbers[one], numbers.get(second, [])):
                    found.append((b, a, PairKind.SELF))
        for name, some in numbers.items():
            kind, kind_moving = _kinds(name)
            if name == "floor":
                continue
            found += [(a, b, kind) for a, b in product(some, self.fixed)]
            found += [(a, b, kind_moving) for a, b in product(some, self.moving)]
            if kind is PairKind.ARM:
                found += [(a, b, kind) for a, b in product(some, loose)]
        found += [(numbers["base"][0], edge, PairKind.BASE) for edge in edges]
        for a, b, _ in found:
            self._shapes.addCollisionPair(pin.CollisionPair(a, b))
        table = np.array(found, dtype=np.int64).reshape(-1, 3)
        return Pairs(*table.T)

    def _reach(self) -> Array:
        """(G, n); from a joint to a shape it is never farther than the links between are long."""
        model, chain = self._model, self._chain
        n_base, axes = model.n_base, model.description.base.axes
        foot = hypot(*model.description.bTa.translation[:2].tolist())
        hops = [float(np.linalg.norm(one.translation)) for one in chain.jointPlacements]
        rows = np.zeros((len(self._moves), model.n))
        for shape, joint in enumerate(self._moves):
            if joint == 0 or not np.isfinite(self._half[shape]).all():
                continue
            corners = _corners(self._shapes.geometryObjects[shape].placement, self._half[shape])
            around_axis = float(np.hypot(corners[:, 0], corners[:, 1]).max())
            away = float(np.linalg.norm(corners, axis=1).max())
            if joint > n_base:
                rows[shape, joint - 1] = around_axis
            for number in range(joint - 1, n_base, -1):
                away += hops[number + 1]
                rows[shape, number - 1] = away
            swing = foot + rows[shape, n_base] if joint > n_base else around_axis
            rows[shape, :n_base] = np.abs(axes[:2]).sum(axis=0) + swing * np.abs(axes[2])
        return rows


def _corners(pose: SE3, half: Array) -> Array:
    """(8, 3) of the box around a shape, in the frame of its pose [m]."""
    signs = np.array(list(product((-1.0, 1.0), repeat=3)))
    return np.asarray((signs * half) @ pose.rotation.T + pose.translation)


class CollisionModels:
    """The collision model of what stands around now, made once for all who measure.

    Args:
        model: the robot.
    """

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._known = OPEN_FLOOR
        self._now: CollisionModel | None = None

    def around(self, surroundings: Surroundings) -> CollisionModel:
        """The same object as long as the same shapes stand around and are held."""
        if self._now is None or not surroundings.has_shapes_of(self._known):
            self._now = CollisionModel(self._model, surroundings)
        self._known = surroundings
        return self._now


_KINDS = {
    "base": (PairKind.BASE, PairKind.BASE_MOVING),
    "link0": (PairKind.BASE, PairKind.BASE_MOVING),
    "hand": (PairKind.HAND, PairKind.ARM_MOVING),
    "palm": (PairKind.PALM, PairKind.ARM_MOVING),
    "held": (PairKind.HAND, PairKind.ARM_MOVING),
}
"""How parts of the robot meet what stands around, and what moves; the others are of the arm."""


def _kinds(part: str) -> tuple[PairKind, PairKind]:
    """How a part of the robot meets what stands around, and what moves."""
    return _KINDS.get(part, (PairKind.ARM, PairKind.ARM_MOVING))
