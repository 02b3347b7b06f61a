"""Whether the robot fits among what stands around it, wherever it may stand."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.base_drive import Pose2D
from controller.command import Array
from controller.floor_map import FloorMap
from controller.model import RobotModel
from robots import Geom, Plane, Sphere, bounding_radius, coal_geometry, half_extents

_POINT = 1e-3
"""Radius of the ball that stands for the tool point [m]."""
_COLUMN = 0.45
"""Height of the part of the arm that stands above the base in every posture [m]."""

ARM = ("arm",)
"""What is elsewhere in every posture that brings the hand to a goal."""
WHOLE = ("arm", "wrist", "camera", "hand")
"""Everything above the base."""


class Nearest(NamedTuple):
    """What comes nearest to what."""

    distance: float
    """Between their surfaces [m]; negative if they overlap."""
    part: str = ""
    """Of the robot."""
    fixture: str = ""


class FreeSpace:
    """The fixtures around one robot.

    Not to be shared between threads: Pinocchio's and Coal's workspaces are reused.

    Args:
        model: the robot.
        fixtures: what never moves, in the world.
    """

    def __init__(self, model: RobotModel, fixtures: tuple[Geom, ...]) -> None:
        self._model = model
        self.fixtures = fixtures
        self.floor = FloorMap(fixtures, model.description)
        """The same, seen from above."""
        self._chain = model.chain.copy()
        self._data = self._chain.createData()
        self._shapes = pin.GeometryModel()
        parts = _parts(model)
        self._parts = [name for name, _, _ in parts]
        self._radii = np.array([bounding_radius(part.shape) for _, _, part in parts])
        for _, joint, part in parts:
            self._add(joint, part)
        self._solid = [one for one in fixtures if not isinstance(one.shape, Plane)]
        self._half = np.array([half_extents(one.shape) for one in self._solid]).reshape(-1, 3)
        self._axes = np.array([one.pose.rotation for one in self._solid]).reshape(-1, 3, 3)
        self._centres = np.array([one.pose.translation for one in self._solid]).reshape(-1, 3)
        for fixture in self._solid:
            self._add(0, fixture)
        moving, still = range(len(parts)), range(len(parts), len(parts) + len(self._solid))
        for pair in product(moving, still):
            self._shapes.addCollisionPair(pin.CollisionPair(*pair))
        self._results = pin.GeometryData(self._shapes)

    def _add(self, joint: int, part: Geom) -> None:
        name, shape = f"{part.name}_{self._shapes.ngeoms}", coal_geometry(part.shape)
        self._shapes.addGeometryObject(pin.GeometryObject(name, joint, 0, part.pose, shape))

    def nearest(self, wTb: SE3, q: Array, parts: tuple[str, ...], within: float) -> Nearest:
        """The part of the robot that is nearest to a fixture.

        Args:
            wTb: base pose.
            q: (7,) joint positions [rad].
            parts: which ones count: `arm`, `wrist`, `camera`, `hand` or `tool`.
            within: what is farther than this is not looked at [m].
        """
        if not self._solid:
            return Nearest(within)
        self._chain.jointPlacements[1] = wTb
        joints = self._model.joints(q)
        pin.updateGeometryPlacements(self._chain, self._data, self._shapes, self._results, joints)
        some = [number for number, part in enumerate(self._parts) if part in parts]
        centres = np.array([self._results.oMg[number].translation for number in some])
        seen = np.einsum("pfi,fij->pfj", centres[:, None] - self._centres, self._axes)
        outside = np.linalg.norm(np.maximum(np.abs(seen) - self._half, 0.0), axis=2)
        found = Nearest(within)
        for row, fixture in zip(
            *np.nonzero(outside < within + self._radii[some, None]), strict=True
        ):
            pair = some[row] * len(self._solid) + int(fixture)
            pin.computeDistance(self._shapes, self._results, pair)
            distance = float(self._results.distanceResults[pair].min_distance)
            if distance < found.distance:
                found = Nearest(distance, self._parts[some[row]], self._solid[fixture].name)
        return found

    def hand_at(self, wTe: SE3, parts: tuple[str, ...], within: float) -> Nearest:
        """The same for parts that move with the hand, the end effector being at `wTe`."""
        q = self._model.description.arm.ready
        return self.nearest(wTe * self._model.bTe(q).inverse(), q, parts, within)

    def blocking(self, base: Pose2D, distance: float) -> list[str]:
        """Names of what stands nearer than `distance` [m] to the base at a pose."""
        length, width, height = self._model.description.base.size
        top = height + _COLUMN
        c, s = np.cos(base.heading), np.sin(base.heading)
        x, y = np.meshgrid(*(np.linspace(-side / 2.0, side / 2.0, 7) for side in (length, width)))
        points = np.stack([base.x + c * x - s * y, base.y + s * x + c * y], axis=-1).reshape(-1, 2)
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


def _parts(model: RobotModel) -> list[tuple[str, int, Geom]]:
    """Name, joint and shape, in the frame of the joint, of everything above the base."""
    robot, last = model.description, model.n
    lTe = robot.arm.lTh * robot.gripper.hTe
    found = []
    for link, shapes in enumerate(robot.arm.collision):
        lTj = SE3.Identity() if link else robot.bTa
        name = "wrist" if link == len(robot.arm.collision) - 1 else "arm"
        found += [(name, model.n_base + link, shape.moved(lTj)) for shape in shapes]
    found += [("hand", last, shape.moved(robot.arm.lTh)) for shape in robot.gripper.collision]
    found += [("camera", last, robot.camera.body.moved(lTe * robot.camera.eTc))]
    found += [("tool", last, Geom(Sphere(_POINT), lTe, "tool"))]
    return found


def se3_of(base: Pose2D) -> SE3:
    """A pose on the floor as one in space."""
    return SE3(pin.utils.rotate("z", base.heading), np.array([base.x, base.y, 0.0]))


def group_names(names: list[str]) -> str:
    """The parts of names before `/`, each once, the most frequent first, at most three."""
    groups = [name.partition("/")[0] for name in names]
    return ", ".join(sorted(dict.fromkeys(groups), key=lambda group: -groups.count(group))[:3])
