"""Distances of the arm to itself, the base and the floor.

The arm is made of capsules, the base is a box, the floor a half-space, and Coal measures between
them. The floor moves with the base, as it is flat: only the joints of the arm matter.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array
from controller.model import RobotModel
from robots import Box, Geom, Plane, coal_geometry


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
        robot = model.description
        parts: dict[str, list[int]] = {}
        for link, shapes in enumerate(robot.arm.collision):
            joint, jTl = (0, robot.bTa) if link == 0 else (model.n_base + link, SE3.Identity())
            parts[f"link{link}"] = [self._add(joint, shape.moved(jTl)) for shape in shapes]
        parts["hand"] = [
            self._add(model.n, shape.moved(robot.arm.lTh)) for shape in robot.gripper.collision
        ]
        length, width, height = robot.base.size
        middle = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
        base = Box((length / 2.0, width / 2.0, height / 2.0))
        parts["base"] = [self._add(0, Geom(base, middle, "base"))]
        parts["floor"] = [self._add(0, Geom(Plane(), SE3.Identity(), "floor"))]
        for first, second in robot.arm.may_touch:
            for a, b in product(parts[first], parts[second]):
                self._shapes.addCollisionPair(pin.CollisionPair(min(a, b), max(a, b)))
        self._results = pin.GeometryData(self._shapes)
        self._checked = np.full(model.n - model.n_base, np.inf)
        self._clearance = 0.0

    def _add(self, joint: int, part: Geom) -> int:
        name, shape = f"{part.name}_{self._shapes.ngeoms}", coal_geometry(part.shape)
        return int(
            self._shapes.addGeometryObject(pin.GeometryObject(name, joint, 0, part.pose, shape))
        )

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
        moved = float(np.abs(q - self._checked) @ self._model.description.arm.reach)
        if self._clearance - moved > within:
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
