"""Free space: distances of the robot to static obstacles at any base pose."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.arrays import Array
from config.planar import Pose2D, act
from config.poses import MapPose
from controller.collision.collision_model import CollisionModel
from controller.floor.floor_map import COLUMN, FloorMap
from controller.model import RobotModel
from controller.surroundings import Surroundings
from robots import Plane, half_extents


class Nearest(NamedTuple):
    """The nearest part of the robot and fixture."""

    distance: float  # between their surfaces [m]; negative if they overlap
    part: str = ""
    fixture: str = ""


class FreeSpace:
    """The fixtures around one robot; not thread-safe, as workspaces are reused.

    Without a collision model it makes its own, with an empty hand.
    """

    def __init__(
        self, model: RobotModel, floor: FloorMap, collision: CollisionModel | None = None
    ) -> None:
        self._model = model
        *arm, last = (f"link{link}" for link in range(model.n_arm + 1))
        self.arm = tuple(arm)  # parts whose place depends on the posture
        self.hand = (last, "hand", "camera", "held")  # parts whose place is given by the goal
        self.parts = (*self.arm, *self.hand, "palm")  # parts that must have room
        self.floor = floor  # map of the fixtures
        collision = collision or CollisionModel(model, Surroundings(fixtures=floor.fixtures))
        numbered = zip(floor.fixtures, collision.fixed, strict=True)
        known = [(one, number) for one, number in numbered if not isinstance(one.shape, Plane)]
        solid = [one for one, _ in known]
        self._collision = collision
        self._solid = solid
        self._half = np.array([half_extents(one.shape) for one in solid]).reshape(-1, 3)
        self._axes = np.array([one.pose.rotation for one in solid]).reshape(-1, 3, 3)
        self._centres = np.array([one.pose.translation for one in solid]).reshape(-1, 3)
        pairs = collision.pairs
        around = np.flatnonzero(np.isin(pairs.second, [number for _, number in known]))
        shapes = len(around) // max(1, len(solid))
        self._pairs = around.reshape(shapes, len(solid))  # (shapes, fixtures) indices of the pairs
        self._shapes = pairs.first[self._pairs[:, 0]] if solid else np.zeros(0, np.int64)

    def nearest(self, mTb: MapPose, q: Array, parts: tuple[str, ...], within: float) -> Nearest:
        """The nearest of some parts to a fixture, at q (j,) [rad] and at most `within` [m]."""
        found, collision = Nearest(within), self._collision
        if not self._solid:
            return found
        collision.place(mTb, q)
        names = collision.names
        some = [row for row, shape in enumerate(self._shapes) if names[shape] in parts]
        balls = [collision.ball(int(self._shapes[row])) for row in some]
        seen = np.einsum(
            "pfi,fij->pfj", np.array([c for c, _ in balls])[:, None] - self._centres, self._axes
        )
        away = np.linalg.norm(np.maximum(np.abs(seen) - self._half, 0.0), axis=2)
        near = away < within + np.array([radius for _, radius in balls])[:, None]
        rows, fixtures = np.nonzero(near)
        if not len(rows):
            return found
        distances = collision.measure(self._pairs[np.array(some)[rows], fixtures].tolist())
        first = int(distances.argmin())
        if distances[first] >= within:
            return found
        name = names[self._shapes[some[rows[first]]]]
        return Nearest(float(distances[first]), name, self._solid[fixtures[first]].name)

    def room(self, base: Pose2D, q: Array, within: float) -> float:
        """Distance of arm and hand to the fixtures at q (j,) [rad], at most `within` [m]."""
        return self.nearest(se3_of(base), q, self.parts, within).distance

    def hand_at(self, mTe: MapPose) -> Nearest:
        """The deepest penetration of the hand with the end effector at `mTe`."""
        q = self._model.description.arm.ready
        return self.nearest(mTe * self._model.bTe(q).inverse(), q, self.hand, 0.0)

    def around(self, point: Array) -> str:
        """Name of the fixture whose bounding box a point (3,) is in; empty if there is none."""
        seen = np.einsum("fi,fij->fj", point - self._centres, self._axes)
        inside = np.flatnonzero((np.abs(seen) <= self._half).all(axis=1))
        return self._solid[inside[0]].name if len(inside) else ""

    def blocking(self, base: Pose2D, distance: float) -> list[str]:
        """Names of the fixtures nearer than `distance` [m] to the base at a pose."""
        length, width, height = self._model.description.base.size
        top = height + COLUMN
        x, y = np.meshgrid(*(np.linspace(-side / 2.0, side / 2.0, 7) for side in (length, width)))
        points = np.stack(act(base, x, y), axis=-1).reshape(-1, 2)
        near = []
        for fixture, half, R, p in zip(
            self._solid, self._half, self._axes, self._centres, strict=True
        ):
            tall = float(np.abs(R[2]) @ half)
            z = np.clip(p[2], 0.0, top)
            seen = (np.column_stack([points, np.full(len(points), z)]) - p) @ R
            away = np.linalg.norm(np.maximum(np.abs(seen) - half, 0.0), axis=1).min()
            if away < distance and p[2] - tall < top:
                near.append(fixture.name)
        return near


def se3_of(base: Pose2D) -> SE3:
    """A pose on the floor as one in space."""
    return SE3(pin.utils.rotate("z", base.heading), np.array([base.x, base.y, 0.0]))


def group_names(names: list[str]) -> str:
    """At most three of the different parts of names before `/`, the most frequent first."""
    groups = [name.partition("/")[0] for name in names]
    return ", ".join(sorted(dict.fromkeys(groups), key=lambda group: -groups.count(group))[:3])
