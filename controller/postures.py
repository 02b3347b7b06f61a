"""A bank of good arm postures, to look up a stance for a goal.

The base can choose x, y and heading freely, so a posture suits a goal if its end effector has the
goal's height and tilt; the rest is the pose of the base. The bank was drawn once, at random with a
seed, from postures that are dexterous, inside the joint limits and clear of the robot itself and
the floor; it comes with the package.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import pi
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.command import N_ARM, Array
from controller.model import RobotModel
from controller.self_collision import SelfCollision
from robots import RobotDescription, load_robot, robot_names

BANK = Path(__file__).with_name("postures.npy")
"""The stored bank: (60 000, 7) joint positions in half precision [rad], from `draw` with `SEED`."""
SEED = 20220101

# What the stored bank was drawn with: it has to be drawn again when one of these changes.
_LIMIT_MARGIN = 0.2
"""Least distance to every joint limit [rad]."""
_MIN_MANIPULABILITY = 0.035
_MAX_BEARING = 0.3
"""Largest |θ_ε|, the bearing of the end effector seen from the arm's foot [rad]."""
_MIN_REACH = 0.25
"""Least horizontal distance of the end effector from the arm's foot [m]."""
_CLEARANCE = 0.03
"""Least distance from the robot itself and the floor [m]."""
_DRAWN_AT_ONCE = 4096


class ToolPoses(NamedTuple):
    """The end effector in the base frame, in each of N postures."""

    positions: Array
    """(N, 3) [m]."""
    rotations: Array
    """(N, 3, 3)."""
    J: Array
    """(N, 6, 7) Jacobians at the end effector, linear first, in base axes."""

    @property
    def manipulability(self) -> Array:
        """(N,) Yoshikawa's measure."""
        J = self.J
        squared: Array = np.linalg.det(J @ np.swapaxes(J, 1, 2))
        return np.sqrt(np.maximum(squared, 0.0))


def forward_kinematics(robot: RobotDescription, q: Array) -> ToolPoses:
    """Forward kinematics of many postures at once.

    Args:
        robot: its arm, where it stands on the base, and its gripper.
        q: (N, 7) joint positions [rad].
    """
    count = len(q)
    positions = np.tile(robot.bTa.translation, (count, 1))
    rotations = np.tile(robot.bTa.rotation, (count, 1, 1))
    origins, axes = np.empty((count, N_ARM, 3)), np.empty((count, N_ARM, 3))
    for joint, placement in enumerate(robot.arm.joints):
        positions = positions + rotations @ placement.translation
        rotations = _turned(rotations @ _clean(placement.rotation), q[:, joint])
        origins[:, joint], axes[:, joint] = positions, rotations[:, :, 2]
    lTe = robot.arm.lTh * robot.gripper.hTe
    positions = positions + rotations @ lTe.translation
    linear = np.cross(axes, positions[:, None] - origins)
    J = np.concatenate([np.swapaxes(linear, 1, 2), np.swapaxes(axes, 1, 2)], axis=1)
    return ToolPoses(positions, rotations @ lTe.rotation, J)


def _clean(rotation: Array) -> Array:
    """A rotation without the rounding errors of quarter turns."""
    whole = np.round(rotation)
    return np.where(np.abs(rotation - whole) < 1e-12, whole, rotation)


def _turned(rotations: Array, angles: Array) -> Array:
    """Rotations (N, 3, 3), each turned by an angle about its own z."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y, z = rotations[:, :, 0], rotations[:, :, 1], rotations[:, :, 2]
    return np.stack([x * c + y * s, y * c - x * s, z], axis=2)


class Bank(NamedTuple):
    """The bank for one robot, sorted by the height of the end effector."""

    q: Array
    """(N, 7) joint positions [rad]."""
    tools: ToolPoses


@lru_cache(maxsize=4)
def bank(robot: RobotDescription) -> Bank:
    """The stored postures that a robot may take."""
    q = np.load(BANK).astype(float)
    q = q[((robot.limits.q_min <= q) & (q <= robot.limits.q_max)).all(axis=1)]
    tools = forward_kinematics(robot, q)
    order = np.argsort(tools.positions[:, 2])
    return Bank(q[order], ToolPoses(*(values[order] for values in tools)))


def draw(count: int, rng: np.random.Generator) -> Array:
    """Draw a bank of (count, 7) postures that are good on every shipped robot [rad]."""
    robots = [load_robot(name) for name in robot_names()]
    collisions = [SelfCollision(RobotModel(robot)) for robot in robots]
    on_the_floor, limits = replace(robots[0], bTa=SE3.Identity()), robots[0].limits
    low, high = limits.q_min + _LIMIT_MARGIN, limits.q_max - _LIMIT_MARGIN
    drawn: list[Array] = []
    while len(drawn) < count:
        q = rng.uniform(low, high, size=(_DRAWN_AT_ONCE, N_ARM))
        q[:, 0] = 0.0
        tools = forward_kinematics(on_the_floor, q)
        x, y = tools.positions[:, 0], tools.positions[:, 1]
        q[:, 0] = rng.uniform(-_MAX_BEARING, _MAX_BEARING, len(q)) - np.arctan2(y, x)
        q[:, 0] = (q[:, 0] + pi) % (2.0 * pi) - pi
        good = (
            (tools.manipulability > _MIN_MANIPULABILITY)
            & (np.hypot(x, y) > _MIN_REACH)
            & (np.abs(q[:, 0]) < high[0])
        )
        drawn += [p for p in q[good] if all(c.clearance(p) > _CLEARANCE for c in collisions)]
    return np.array(drawn[:count])
