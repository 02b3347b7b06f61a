"""Checks whether the arm touches itself, the base or the floor.

The arm is made of capsules with the radii of the manufacturer's self-collision model, the base is a
box, the floor a half-space. The controller has shapes of its own.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import N_ARM, Array, RobotModel

_Point = tuple[float, float, float]


class _Capsule(NamedTuple):
    """A capsule on a link: the ends of its axis in the link's frame, and its radius [m]."""

    link: int
    start: _Point
    end: _Point
    radius: float


HAND = 8
"""Links are counted from the arm's foot (0) to the hand."""

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

_SHOULDER = (1, 3)
"""The link between these two is so short that their capsules always overlap."""
_ON_THE_BASE = (0, 1)
"""Links that touch the base because they are mounted on it."""

SURFACE = 1e-6
"""Shapes that overlap by less than this do not touch [m]."""


class Contacts(NamedTuple):
    """What the arm touches in one posture."""

    arm: bool
    """Two links that are not neighbours touch each other."""
    base: bool
    floor: bool

    @property
    def any(self) -> bool:
        """Whether it touches anything."""
        return self.arm or self.base or self.floor


def _placed(shape: _Capsule) -> tuple[coal.Capsule, SE3]:
    start, end = np.array(shape.start), np.array(shape.end)
    axis = end - start
    length = float(np.linalg.norm(axis))
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), axis / length)
    return coal.Capsule(shape.radius - SURFACE, length), SE3(turn, (start + end) / 2.0)


class ContactChecker:
    """Checks what the arm of one robot touches.

    Args:
        model: the robot; its chain of joints carries the shapes.
    """

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        links = model.link_poses(SE3.Identity(), np.zeros(N_ARM))
        geometry = pin.GeometryModel()

        def add(name: str, joint: int, placement: SE3, shape: object) -> int:
            return int(
                geometry.addGeometryObject(pin.GeometryObject(name, joint, placement, shape))
            )

        for number, capsule in enumerate(CAPSULES):
            shape, placement = _placed(capsule)
            moves_with = min(capsule.link, N_ARM)
            joint = model.n_base + moves_with if moves_with else 0
            frame = links[moves_with] if moves_with else SE3.Identity()
            add(f"capsule{number}", joint, frame.actInv(links[capsule.link] * placement), shape)
        height = float(links[0].translation[2])
        box = coal.Box(*model.description.base.size[:2], height)
        base = add("base", 0, SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0])), box)
        floor = add("floor", 0, SE3.Identity(), coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0))

        self._geometry = geometry
        self._kinds: list[str] = []
        for a, b in combinations(range(len(CAPSULES)), 2):
            pair = (CAPSULES[a].link, CAPSULES[b].link)
            if pair[1] - pair[0] > 1 and pair != _SHOULDER:
                self._add_pair("arm", a, b)
        for number, capsule in enumerate(CAPSULES):
            if capsule.link not in _ON_THE_BASE:
                self._add_pair("base", number, base)
                self._add_pair("floor", number, floor)
        self._data = model.chain.createData()
        self._geometry_data = pin.GeometryData(geometry)

    def _add_pair(self, kind: str, a: int, b: int) -> None:
        self._geometry.addCollisionPair(pin.CollisionPair(a, b))
        self._kinds.append(kind)

    def __call__(self, q: Array) -> Contacts:
        """What the arm touches at joint positions q (7,) [rad]."""
        if not self._touching(q, True):
            return Contacts(False, False, False)
        found = {kind for kind, _ in self._pairs_in_contact(q)}
        return Contacts("arm" in found, "base" in found, "floor" in found)

    def _pairs_in_contact(self, q: Array) -> list[tuple[str, Any]]:
        self._touching(q, False)
        return [
            (kind, pair)
            for kind, pair, result in zip(
                self._kinds,
                self._geometry.collisionPairs,
                self._geometry_data.collisionResults,
                strict=True,
            )
            if result.isCollision()
        ]

    def _touching(self, q: Array, stop_at_first: bool) -> bool:
        return bool(
            pin.computeCollisions(
                self._model.chain,
                self._data,
                self._geometry,
                self._geometry_data,
                self._model.joints(q),
                stop_at_first,
            )
        )
