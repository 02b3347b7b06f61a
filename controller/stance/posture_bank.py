"""A bank of good arm postures, to look up a stance for a goal.

The base can choose x, y and heading freely, so a posture suits a goal if its end effector has the
goal's height and tilt; the rest is the pose of the base. The bank was drawn once, at random with a
seed, from postures that are dexterous, inside the joint limits and clear of the robot itself and
the floor; it comes with the package.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.collision import SelfCollision
from controller.command import N_ARM, Array
from controller.floor import wrap
from controller.model import RobotModel
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

    def turned(self, bTa: SE3, turns: Array) -> ToolPoses:
        """The same with the first joints turned by (N,) angles [rad]; J is as it was.

        Args:
            bTa: foot of the arm, upright.
            turns: (N,) [rad].
        """
        c, s, zero = np.cos(turns), np.sin(turns), np.zeros(len(turns))
        R = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1.0], axis=1).reshape(-1, 3, 3)
        foot = bTa.translation
        positions = foot + (R @ (self.positions - foot)[:, :, None])[:, :, 0]
        return ToolPoses(positions, R @ self.rotations, self.J)


def forward_kinematics(robot: RobotDescription, q: Array) -> ToolPoses:
    """Forward kinematics of many postures at once.

    Args:
        robot: its arm, where it stands on the base, and its gripper.
        q: (N, 7) joint positions [rad].
    """
    chain = _Chain.of(robot)
    c, s = np.cos(q), np.sin(q)
    # Joint j on joint j - 1: its placement, turned about its own z.
    x, y = chain.placements[:, :, 0], chain.placements[:, :, 1]
    turned = np.empty((len(q), N_ARM, 4, 4))
    turned[:] = chain.placements
    turned[..., 0] = x * c[..., None] + y * s[..., None]
    turned[..., 1] = y * c[..., None] - x * s[..., None]
    bTj = np.empty_like(turned)
    bTj[:, 0] = chain.bTa @ turned[:, 0]
    for joint in range(1, N_ARM):
        np.matmul(bTj[:, joint - 1], turned[:, joint], out=bTj[:, joint])
    bTe = bTj[:, -1] @ chain.lTe
    axes = np.ascontiguousarray(bTj[..., :3, 2].transpose(2, 0, 1))
    arms = bTe[:, :3, 3].T[:, :, None] - bTj[..., :3, 3].transpose(2, 0, 1)
    J = np.empty((len(q), 6, N_ARM))
    for row, (i, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        J[:, row] = axes[i] * arms[k] - axes[k] * arms[i]
        J[:, 3 + row] = axes[row]
    return ToolPoses(bTe[:, :3, 3], bTe[:, :3, :3], J)


class _Chain(NamedTuple):
    """The constant transforms of one arm, homogeneous."""

    bTa: Array
    placements: Array
    """(7, 4, 4) of every joint on the one before it."""
    lTe: Array

    @classmethod
    @lru_cache(maxsize=8)
    def of(cls, robot: RobotDescription) -> _Chain:
        """Those of a robot; made once."""
        placements = [_clean(placement.homogeneous) for placement in robot.arm.joints]
        lTe = robot.arm.lTh * robot.gripper.hTe
        return cls(robot.bTa.homogeneous, np.array(placements), lTe.homogeneous)


def _clean(transform: Array) -> Array:
    """A transform without the rounding errors of quarter turns."""
    whole = np.round(transform)
    return np.where(np.abs(transform - whole) < 1e-12, whole, transform)


class PostureBank(NamedTuple):
    """The bank for one robot, sorted by the height of the end effector."""

    q: Array
    """(N, 7) joint positions [rad]."""
    tools: ToolPoses


@lru_cache(maxsize=4)
def bank(robot: RobotDescription) -> PostureBank:
    """The stored postures that a robot may take."""
    q = np.load(BANK).astype(float)
    q = q[((robot.limits.q_min <= q) & (q <= robot.limits.q_max)).all(axis=1)]
    tools = forward_kinematics(robot, q)
    order = np.argsort(tools.positions[:, 2])
    return PostureBank(q[order], ToolPoses(*(values[order] for values in tools)))


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
        q[:, 0] = wrap(q[:, 0])
        good = (
            (tools.manipulability > _MIN_MANIPULABILITY)
            & (np.hypot(x, y) > _MIN_REACH)
            & (np.abs(q[:, 0]) < high[0])
        )
        drawn += [p for p in q[good] if all(c.clearance(p) > _CLEARANCE for c in collisions)]
    return np.array(drawn[:count])
