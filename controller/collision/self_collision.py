"""Self-collision: distances of the arm to itself, the base and the floor.

Coal measures between the shapes of the arm, the box of the base and the half-space of the floor.
The floor moves with the base, as it is flat: only the joints of the arm matter.
"""

from itertools import product

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array
from controller.model import RobotModel
from robots import Box, Geom, Plane, coal_geometry

_NO_PAIR = 10.0  # distance where nothing can touch [m]


class SelfCollision:
    """The collision shapes of one robot; not thread-safe, as workspaces are reused."""

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
        lTc = robot.arm.lTh * robot.gripper.hTe * robot.camera.eTc
        parts["camera"] = [self._add(model.n, robot.camera.body.moved(lTc))]
        length, width, height = robot.base.size
        middle = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
        base = Box((length / 2.0, width / 2.0, height / 2.0))
        parts["base"] = [self._add(0, Geom(base, middle, "base"))]
        parts["floor"] = [self._add(0, Geom(Plane(), SE3.Identity(), "floor"))]
        for first, second in robot.arm.may_touch:
            for a, b in product(parts[first], parts[second]):
                self._shapes.addCollisionPair(pin.CollisionPair(min(a, b), max(a, b)))
        self._results = pin.GeometryData(self._shapes)

    def _add(self, joint: int, part: Geom) -> int:
        name, shape = f"{part.name}_{self._shapes.ngeoms}", coal_geometry(part.shape)
        return int(
            self._shapes.addGeometryObject(pin.GeometryObject(name, joint, 0, part.pose, shape))
        )

    def clearance(self, q: Array) -> float:
        """Smallest distance of the arm to itself, the base and the floor, for q (j,) [m].

        10 m if none of them can touch.
        """
        if not self._shapes.collisionPairs:
            return _NO_PAIR
        joints = self._model.joints(q)
        nearest = pin.computeDistances(
            self._model.chain, self._data, self._shapes, self._results, joints
        )
        return float(self._results.distanceResults[nearest].min_distance)
