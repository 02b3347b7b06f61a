"""Contacts of the arm with itself, the base and the floor.

Capsules with the radii of the manufacturer's self-collision model, a box for the base and a
half-space for the floor: shapes that are independent of those of the controller. Of an arm other
than a Panda only the shapes of its own file are known.
"""

from itertools import combinations
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import Array, RobotModel, SelfCollision
from robots import RobotDescription, load_robot

_Point = tuple[float, float, float]


class _Capsule(NamedTuple):
    """A capsule on a link: the ends of its axis in the link's frame, and its radius [m]."""

    link: int
    start: _Point
    end: _Point
    radius: float


_N = 7
HAND = 8  # number of the hand; link 0 is the foot of the arm

CAPSULES = (
    _Capsule(0, (-0.09, 0.0, 0.06), (-0.06, 0.0, 0.06), 0.06),
    _Capsule(1, (0.0, 0.0, -0.333), (0.0, 0.0, -0.05), 0.06),
    _Capsule(2, (0.0, 0.0, -0.06), (0.0, 0.0, 0.06), 0.06),
    _Capsule(3, (0.0, 0.0, -0.22), (0.0, 0.0, -0.07), 0.06),
    _Capsule(4, (0.0, 0.0, -0.06), (0.0, 0.0, 0.06), 0.06),
    _Capsule(5, (0.0, 0.0, -0.31), (0.0, 0.0, -0.21), 0.06),
    _Capsule(5, (0.0, 0.08, -0.20), (0.0, 0.08, -0.06), 0.025),
    _Capsule(6, (0.0, 0.0, -0.07), (0.0, 0.0, 0.01), 0.05),
    _Capsule(7, (0.0, 0.0, -0.06), (0.0, 0.0, 0.08), 0.04),
    _Capsule(HAND, (0.0, -0.05, 0.04), (0.0, 0.05, 0.04), 0.04),
    _Capsule(HAND, (0.0, -0.05, 0.10), (0.0, 0.05, 0.10), 0.02),
)
"""The arm's foot, its seven links and the hand with open fingers."""

_SHOULDER = (1, 3)  # the link between these two is so short that their capsules always overlap
_ON_THE_BASE = (0, 1)  # links that touch the base because they are mounted on it

SURFACE = 1e-6  # shapes that overlap by less than this do not touch [m]


def is_panda(robot: RobotDescription) -> bool:
    """Whether these are the shapes of its arm."""
    return robot.arm.is_like(load_robot("frankie").arm)


def capsule_on_link(capsule: _Capsule, shrunk: float = 0.0) -> tuple[float, float, SE3]:
    """Radius less `shrunk`, length [m] and pose of a capsule along z, on its link."""
    start, end = np.array(capsule.start), np.array(capsule.end)
    axis = end - start
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis)
    return capsule.radius - shrunk, float(np.linalg.norm(axis)), SE3(turn, (start + end) / 2.0)


class ContactChecker:
    """Contacts of the arm of one robot, with itself, the base and the floor."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._own = None if is_panda(model.description) else SelfCollision(model)
        if self._own is not None:
            return
        links = model.link_poses(SE3.Identity(), np.zeros(_N))
        geometry = self._geometry = pin.GeometryModel()

        def add(name: str, joint: int, placement: SE3, shape: object) -> int:
            return int(
                geometry.addGeometryObject(pin.GeometryObject(name, joint, placement, shape))
            )

        for number, capsule in enumerate(CAPSULES):
            radius, length, placement = capsule_on_link(capsule, SURFACE)
            moves_with = min(capsule.link, _N)
            joint = model.n_base + moves_with if moves_with else 0
            frame = links[moves_with] if moves_with else SE3.Identity()
            on_joint = frame.actInv(links[capsule.link] * placement)
            add(f"capsule{number}", joint, on_joint, coal.Capsule(radius, length))
        height = float(links[0].translation[2])
        box = coal.Box(*model.description.base.size[:2], height)
        base = add("base", 0, SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0])), box)
        floor = add("floor", 0, SE3.Identity(), coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0))

        for a, b in combinations(range(len(CAPSULES)), 2):
            pair = (CAPSULES[a].link, CAPSULES[b].link)
            if pair[1] - pair[0] > 1 and pair != _SHOULDER:
                geometry.addCollisionPair(pin.CollisionPair(a, b))
        for number, capsule in enumerate(CAPSULES):
            if capsule.link not in _ON_THE_BASE:
                geometry.addCollisionPair(pin.CollisionPair(number, base))
                geometry.addCollisionPair(pin.CollisionPair(number, floor))
        self._data = model.chain.createData()
        self._geometry_data = pin.GeometryData(geometry)

    def __call__(self, q: Array, margin: float = 0.0) -> bool:
        """Whether the arm touches itself, the base or the floor at joint positions q (j,) [rad].

        Neighbouring links do not count. Shapes of its own file, which are loose, touch when they
        are nearer than `margin` [m].
        """
        if self._own is not None:
            return self._own.clearance(q) < margin - SURFACE
        model = self._model
        return bool(
            pin.computeCollisions(
                model.chain,
                self._data,
                self._geometry,
                self._geometry_data,
                model.joints(q),
                True,  # stop at the first
            )
        )
