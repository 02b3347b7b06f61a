"""Collision model of the robot among obstacles: shapes, pairs, and distances measured by Coal.

Everything is on the map; the first joint placement of the chain is the base pose.
"""

from collections.abc import Callable, Sequence
from copy import copy
from enum import IntEnum
from functools import lru_cache
from itertools import product
from math import hypot
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.arrays import Array, Indices
from config.poses import MapPose
from controller.collision.robot_shapes import Part, held_parts, robot_parts, upright_edges
from controller.model import RobotModel
from controller.surroundings import OPEN_FLOOR, Surroundings
from robots import CORNERS, Geom, bounding_radius, coal_geometry, half_extents


class PairKind(IntEnum):
    """The parts of robot and surroundings that a pair of shapes belongs to."""

    SELF = 0  # the arm and the robot itself, or the floor
    BASE = 1  # the base and a static obstacle
    ARM = 2  # the arm and a static obstacle
    HAND = 3  # hand, fingers or held object and a static obstacle
    PALM = 4  # the palm and a static obstacle; it must not touch even where the fingers may
    BASE_MOVING = 5  # the base and a moving obstacle
    ARM_MOVING = 6  # arm or hand and a moving obstacle
    AHEAD = 7  # the base and the predicted motion of a moving obstacle


class Pairs(NamedTuple):
    """P pairs of shapes that can collide; the first of each is the robot's."""

    first: Indices  # (P,) indices of shapes
    second: Indices  # (P,)
    kind: Indices  # (P,) `PairKind`


class Body(NamedTuple):
    """A shape of the robot that can collide with obstacles."""

    number: int  # index of the shape
    geom: Geom  # in the frame of its link
    kind: PairKind  # with static obstacles


class Shapes:
    """Shapes of a robot and of what is around it, with what is known of each."""

    def __init__(self, model: RobotModel) -> None:
        self._model, robot = model, model.description
        self.geometry = pin.GeometryModel()
        self.names: list[str] = []  # in messages
        self.radius: list[float] = []  # of the bounding ball [m]
        self.moves: list[int] = []
        """Number of degrees of freedom that move each shape, counted from the first."""
        self.reach: list[Array] = []
        """(n,) largest displacement of a point of each per degree of freedom [m/rad]."""
        first = robot.bTa.act(robot.arm.joints[0].translation)
        self._foot = hypot(*first[:2].tolist()) + float(robot.strokes[0])
        hops = [float(np.linalg.norm(one.translation)) for one in model.chain.jointPlacements]
        arm = model.n_base + 1
        self._hops = hops[:arm] + (hops[arm:] + robot.strokes).tolist()

    def copy(self) -> "Shapes":
        """The same shapes, to which others can be added."""
        other = copy(self)
        other.geometry, other.names = self.geometry.copy(), self.names.copy()
        other.radius, other.moves = self.radius.copy(), self.moves.copy()
        other.reach = self.reach.copy()
        return other

    def add(self, name: str, part: Part) -> int:
        """Add a part of the robot; its number."""
        return self._put(self._model.n_base + max(part.link, 0), part.geom, name)

    def add_still(self, geom: Geom) -> int:
        """Add what does not move with the robot; its number."""
        return self._put(0, geom, geom.name)

    def _put(self, joint: int, geom: Geom, name: str) -> int:
        self.moves.append(joint)
        self.radius.append(bounding_radius(geom.shape))
        self.reach.append(self._reach(joint, geom))
        self.names.append(name)
        shape, unique = coal_geometry(geom.shape), f"{name}_{self.geometry.ngeoms}"
        placed = pin.GeometryObject(unique, joint, 0, geom.pose, shape)
        return int(self.geometry.addGeometryObject(placed))

    def _reach(self, joint: int, geom: Geom) -> Array:
        """(n,) `reach`; the distance from a joint is at most the length of the links between."""
        model, robot, half = self._model, self._model.description, half_extents(geom.shape)
        n_base, axes, row = model.n_base, robot.base.axes, np.zeros(model.n)
        if joint == 0 or not np.isfinite(half).all():
            return row
        corners = _corners(geom.pose, np.array(half))
        around_axis = float(np.hypot(corners[:, 0], corners[:, 1]).max())
        away = float(np.linalg.norm(corners, axis=1).max())
        if joint > n_base:
            row[joint - 1] = around_axis
        for number in range(joint - 1, n_base, -1):
            away += self._hops[number + 1]
            row[number - 1] = away
        swing = self._foot + row[n_base] if joint > n_base else around_axis
        row[n_base:joint][robot.arm.slides[: joint - n_base]] = 1.0
        row[:n_base] = np.abs(axes[:2]).sum(axis=0) + swing * np.abs(axes[2])
        return row


class Lasting(NamedTuple):
    """The shapes of a robot with an empty hand and of fixtures."""

    shapes: Shapes
    parts: dict[str, list[Part]]  # of the robot and the floor
    numbers: dict[str, list[int]]  # indices of their shapes
    fixed: list[int]  # indices of the fixtures, in their order
    edges: list[int]  # indices of their upright edges


@lru_cache(maxsize=2)
def _lasting(model: RobotModel, fixtures: tuple[Geom, ...]) -> Lasting:
    """What does not change in a grasp, which leaves the tick little to make."""
    shapes, parts = Shapes(model), robot_parts(model)
    numbers = {name: [shapes.add(name, p) for p in some] for name, some in parts.items()}
    fixed = [shapes.add_still(one) for one in fixtures]
    edges = [shapes.add_still(edge) for one in fixtures for edge in upright_edges(one)]
    return Lasting(shapes, parts, numbers, fixed, edges)


class CollisionModel:
    """One robot among obstacles; not thread-safe, as workspaces are reused."""

    def __init__(self, model: RobotModel, surroundings: Surroundings = OPEN_FLOOR) -> None:
        self._model = model
        self._chain = model.chain.copy()
        self._data = self._chain.createData()
        lasting, parts, numbers, self.fixed, edges = _lasting(model, surroundings.fixtures)
        shapes = lasting.copy()
        parts = parts | {"held": held_parts(model, surroundings.held)}
        numbers = numbers | {"held": [shapes.add("held", one) for one in parts["held"]]}
        self.bodies = [
            # Depth points may be of the grasped object, which comes up to the palm.
            Body(number, part.geom, PairKind.HAND if name == "palm" else _kinds(name)[0])
            for name, some in parts.items()
            if name != "floor"
            for number, part in zip(numbers[name], some, strict=True)
        ]
        self.moving = [shapes.add_still(one.geom) for one in surroundings.moving]
        loose = [shapes.add_still(one) for one in surroundings.loose]
        self._shapes, self._radius, self.names = shapes.geometry, shapes.radius, shapes.names
        self.pairs = pairs = self._pair(numbers, edges, loose)
        self.permanent = ~(np.isin(pairs.first, numbers["held"]) | np.isin(pairs.second, loose))
        """(P,) whether neither is held or loose: these pairs are the same, in the same order, in
        every model with the same fixtures."""
        self.mapped = np.isin(pairs.second, [*self.fixed, *edges])
        """(P,) whether the second is a fixture."""
        self._results = results = pin.GeometryData(self._shapes)
        self._distances = list(results.distanceResults)
        self._normals = [result.normal for result in self._distances]
        """Coal's result for every pair, and the normal in it: views."""
        results.deactivateAllCollisionPairs()
        self._measured: set[int] = set()  # the active pairs
        self._placed = [(one.rotation, one.translation) for one in results.oMg]
        """Rotation (3, 3) and origin (3,) of every shape on the map: views of the results."""
        self.reach = np.array(shapes.reach)
        """(G, n) largest displacement of a point of a shape per degree of freedom [m/rad]."""
        self.masks = np.arange(model.n) < np.array(shapes.moves)[:, None]
        """(G, n) whether a degree of freedom moves the shape."""

    def place(self, mTb: MapPose, q: Array, moving: Sequence[Geom] | None = None) -> None:
        """Place the robot, at q (j,) [rad], and moving obstacles unless `moving` is None."""
        for shape, geom in zip(self.moving, moving, strict=True) if moving else ():
            self._shapes.geometryObjects[shape].placement = geom.pose
        self._chain.jointPlacements[1] = mTb
        self._q = self._model.joints(q)
        pin.updateGeometryPlacements(self._chain, self._data, self._shapes, self._results, self._q)

    def measure(self, pairs: Sequence[int]) -> Array:
        """Distances (K,) of pairs as they are placed [m]."""
        wanted, results = set(pairs), self._results
        for pair in wanted - self._measured:
            results.activateCollisionPair(pair)
        for pair in self._measured - wanted:
            results.deactivateCollisionPair(pair)
        self._measured = wanted
        pin.computeDistances(self._shapes, results)
        return np.array([self._distances[pair].min_distance for pair in pairs])

    def lines(self, pairs: Sequence[int]) -> Array:
        """Plücker lines (K, 6) from first to second through the nearest points, as measured."""
        points = [self._distances[pair].getNearestPoint1() for pair in pairs]
        return lines_along(np.array([self._normals[pair] for pair in pairs]), np.array(points))

    def nearest_points(self, pair: int) -> tuple[Array, Array]:
        """The nearest points (3,) of a pair when it was last measured."""
        result = self._distances[pair]
        return result.getNearestPoint1().copy(), result.getNearestPoint2().copy()

    def poses(self, shapes: Indices) -> tuple[Array, Array]:
        """Rotations (S, 3, 3) and origins (S, 3) of shapes on the map."""
        placed = [self._placed[shape] for shape in shapes.tolist()]
        return np.array([R for R, _ in placed]), np.array([origin for _, origin in placed])

    def ball(self, shape: int) -> tuple[Array, float]:
        """Centre (3,) and radius of the bounding ball of a shape [m]."""
        return self._placed[shape][1], self._radius[shape]

    def jacobian(self) -> Array:
        """(6, n) screws of the joints on the map, linear first."""
        pin.computeJointJacobians(self._chain, self._data, self._q)
        J: Array = self._data.J
        return J

    def clearance(self, q: Array, mTb: MapPose | None = None) -> float:
        """Smallest distance of the robot to itself, floor and static obstacles at q (j,) [m]."""
        self.place(mTb or SE3.Identity(), q)
        return float(self.measure(range(len(self.pairs.first))).min())

    def contact_test(self, mTb: MapPose, pairs: Indices, margins: Array) -> Callable[[Array], bool]:
        """A test at q (j,) whether one of some pairs is nearer than its margin [m]."""
        results = pin.GeometryData(self._shapes)
        results.deactivateAllCollisionPairs()
        for pair, margin in zip(pairs.tolist(), margins.tolist(), strict=True):
            results.activateCollisionPair(pair)
            results.collisionRequests[pair].security_margin = margin

        def touches(q: Array) -> bool:
            self._chain.jointPlacements[1] = mTb
            joints = self._model.joints(q)
            return bool(
                pin.computeCollisions(self._chain, self._data, self._shapes, results, joints, True)
            )

        return touches

    def pair_name(self, pair: int) -> str:
        """The names of the shapes of a pair."""
        pairs = self.pairs
        return f"{self.names[pairs.first[pair]]} and {self.names[pairs.second[pair]]}"

    def _pair(self, numbers: dict[str, list[int]], edges: list[int], loose: list[int]) -> Pairs:
        """All pairs that can collide: of the robot with itself and with obstacles."""
        found: list[tuple[int, int, PairKind]] = []
        may_touch = self._model.description.arm.may_touch
        camera = () if any("camera" in pair for pair in may_touch) else ("camera",)
        aliases = {"hand": ("hand", *camera, "held")}
        for one, other in may_touch:
            seconds = aliases.get(other, (other,))
            if one == "floor" and other == "hand":
                seconds = (*seconds, "palm")  # the hand's capsules do not cover its corners
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


def lines_along(n: Array, p: Array) -> Array:
    """Plücker lines (K, 6) along n (K, 3) through p (K, 3): direction, moment about the origin."""
    (nx, ny, nz), (px, py, pz) = n.T, p.T
    return np.array([nx, ny, nz, py * nz - pz * ny, pz * nx - px * nz, px * ny - py * nx]).T


def _corners(pose: SE3, half: Array) -> Array:
    """(8, 3) corners of the box around a shape, in the frame of its pose [m]."""
    return np.asarray((CORNERS * half) @ pose.rotation.T + pose.translation)


class CollisionModels:
    """Shares one collision model of the present surroundings among its users."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._known = OPEN_FLOOR
        self._now: CollisionModel | None = None

    def around(self, surroundings: Surroundings) -> CollisionModel:
        """The collision model; the same object as long as all shapes are the same."""
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
"""Kinds of pairs of a part with static and moving obstacles; other parts are of the arm."""


def _kinds(part: str) -> tuple[PairKind, PairKind]:
    return _KINDS.get(part, (PairKind.ARM, PairKind.ARM_MOVING))
