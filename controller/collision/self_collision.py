"""Self-collision: distances of the arm to itself, the base and the floor.

Coal measures between the shapes of the arm, the box of the base and the half-space of the floor.
The floor moves with the base, as it is flat: only the joints of the arm matter.
"""

from itertools import product

import pinocchio as pin

from config.arrays import Array
from controller.collision.robot_shapes import robot_parts
from controller.model import RobotModel
from robots import Geom, coal_geometry

_NO_PAIR = 10.0  # distance where nothing can touch [m]


class SelfCollision:
    """The collision shapes of one robot; not thread-safe, as workspaces are reused."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._data = model.chain.createData()
        self._shapes = pin.GeometryModel()
        parts = {
            name: [
                self._add(model.n_base + part.link if part.link > 0 else 0, part.geom)
                for part in some
            ]
            for name, some in robot_parts(model).items()
        }
        parts["base"] = parts["base"][:1]  # its box
        for first, second in model.description.arm.may_touch:
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
