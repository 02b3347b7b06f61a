"""What the robot must not touch with its arm: itself, its base and the floor.

The arm is a string of capsules, the base a box, the floor a half-space, and Coal measures between
them. All of it hangs on the base, and the floor is flat: only the arm's joints count.
"""

from __future__ import annotations

from itertools import product
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array
from controller.model import LINK7_TO_HAND, RobotModel

_HAND = 8
_CAPSULES = (
    # link (0 is the foot, 8 the hand), centre [m], axis, radius [m], length between centres [m]
    (0, (-0.04, 0.0, 0.06), "x", 0.06, 0.03),
    (1, (0.0, 0.0, -0.1915), "z", 0.06, 0.283),
    (2, (0.0, 0.0, 0.0), "z", 0.06, 0.12),
    (3, (0.0, 0.0, -0.145), "z", 0.06, 0.15),
    (4, (0.0, 0.0, 0.0), "z", 0.06, 0.12),
    (5, (0.0, 0.0, -0.26), "z", 0.06, 0.10),
    (5, (0.0, 0.08, -0.13), "z", 0.025, 0.14),
    (6, (0.0, 0.0, -0.03), "z", 0.05, 0.08),
    (7, (0.0, 0.0, 0.01), "z", 0.04, 0.14),
    (8, (0.0, 0.0, 0.04), "y", 0.04, 0.10),
    (8, (0.0, 0.0, 0.10), "y", 0.02, 0.10),
)
_TURNS = {
    "x": pin.utils.rotate("y", np.pi / 2.0),
    "y": pin.utils.rotate("x", np.pi / 2.0),
    "z": np.eye(3),
}
_BASE, _FLOOR = -1, -2
_MAY_TOUCH = (
    *product((0, 1, 2, _BASE), (5, 6, 7, _HAND)),
    *product((3, 5), (_HAND,)),
    *product((_FLOOR,), (6, 7, _HAND)),
)
"""Parts that can come together within the joints' ranges; the second is moved by more joints."""

_LEVERS = np.array([1.1, 1.1, 0.85, 0.85, 0.55, 0.55, 0.25])
"""(7,) how far a point of the arm is at most from each joint's axis [m]."""


class Proximity(NamedTuple):
    """Two parts of the robot that are near each other."""

    distance: float
    """Between their surfaces [m]; negative if they overlap."""
    row: Array
    """(7,) how fast the distance grows per joint velocity [m/rad]."""


class SelfCollision:
    """The shapes of one robot.

    Not to be shared between threads: Pinocchio's and Coal's workspaces are reused.

    Args:
        model: the robot.
    """

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._data = model.chain.createData()
        self._shapes = pin.GeometryModel()
        parts: dict[int, list[int]] = {}
        for link, centre, axis, radius, length in _CAPSULES:
            place = SE3(_TURNS[axis], np.array(centre))
            if link == 0:
                place = model.description.bTa * place
            if link == _HAND:
                place = LINK7_TO_HAND * place
            joint = 0 if link == 0 else model.n_base + min(link, 7)
            shape = coal.Capsule(radius, length)
            parts.setdefault(link, []).append(self._add(f"link{link}", joint, place, shape))
        height = model.description.bTa.translation[2]
        box, middle = coal.Box(*model.description.base_size, height), SE3.Identity()
        middle.translation = np.array([0.0, 0.0, height / 2.0])
        parts[_BASE] = [self._add("base", 0, middle, box)]
        floor = coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
        parts[_FLOOR] = [self._add("floor", 0, SE3.Identity(), floor)]
        for first, second in _MAY_TOUCH:
            for a, b in product(parts[first], parts[second]):
                self._shapes.addCollisionPair(pin.CollisionPair(min(a, b), max(a, b)))
        self._results = pin.GeometryData(self._shapes)
        self._checked = np.full(model.n - model.n_base, np.inf)
        self._clearance = 0.0

    def _add(self, name: str, joint: int, place: SE3, shape: Any) -> int:
        number = self._shapes.ngeoms
        part = pin.GeometryObject(f"{name}_{number}", joint, 0, place, shape)
        return int(self._shapes.addGeometryObject(part))

    def clearance(self, q: Array) -> float:
        """Smallest distance of the arm to itself, the base and the floor, for q (7,) [m]."""
        joints = self._model.joints(q)
        nearest = pin.computeDistances(
            self._model.chain, self._data, self._shapes, self._results, joints
        )
        return float(self._results.distanceResults[nearest].min_distance)

    def near(self, q: Array, within: float) -> list[Proximity]:
        """The pairs of parts that are nearer to each other than `within` [m], for q (7,) [rad].

        Coal is asked only when the arm has moved far enough since it was last asked.
        """
        if self._clearance - float(np.abs(q - self._checked) @ _LEVERS) > within:
            return []
        self._clearance = self.clearance(q)
        self._checked = q.copy()
        if self._clearance > within:
            return []
        return [
            self._proximity(pair, result)
            for pair, result in zip(
                self._shapes.collisionPairs, self._results.distanceResults, strict=True
            )
            if result.min_distance <= within
        ]

    def _proximity(self, pair: pin.CollisionPair, result: pin.DistanceResult) -> Proximity:
        """The distance of one pair and its derivative: the screws seen along the normal."""
        pin.computeJointJacobians(self._model.chain, self._data, self._model.joints(self._checked))
        (nx, ny, nz), row = result.normal, np.zeros(self._model.n)
        for sign, shape, point in (
            (-1.0, pair.first, result.getNearestPoint1()),
            (1.0, pair.second, result.getNearestPoint2()),
        ):
            x, y, z = point
            line = np.array([nx, ny, nz, y * nz - z * ny, z * nx - x * nz, x * ny - y * nx])
            joint = self._shapes.geometryObjects[shape].parentJoint
            row[:joint] += sign * (line @ self._data.J[:, :joint])
        return Proximity(float(result.min_distance), row[self._model.n_base :])
