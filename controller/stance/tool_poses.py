"""End effectors of many arm postures at once: forward kinematics and Jacobians."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from config.arrays import Array
from config.planar import about_z
from robots import RobotDescription, Swivel


class ToolPoses(NamedTuple):
    """The end effector in the base frame, in each of N postures."""

    positions: Array  # (N, 3) [m]
    rotations: Array  # (N, 3, 3)
    J: Array  # (N, 6, 7) Jacobians at the end effector, linear first, in base axes

    def turned(self, swivel: Swivel, turns: Array) -> ToolPoses:
        """The same with the arm turned by (N,) angles about its swivel [rad]; J is not turned."""
        R, pivot = about_z(turns), swivel.pivot
        positions = pivot + (R @ (self.positions - pivot)[:, :, None])[:, :, 0]
        return ToolPoses(positions, R @ self.rotations, self.J)


def forward_kinematics(robot: RobotDescription, q: Array) -> ToolPoses:
    """Forward kinematics of many postures (N, j) at once [rad]."""
    bTa, placements, lTe = _transforms(robot)
    j, slides = len(placements), robot.arm.slides
    c, s = np.cos(q), np.sin(q)
    # Each joint on the one before: its placement, turned about its own z or moved along it.
    x, y = placements[:, :, 0], placements[:, :, 1]
    turned = np.empty((len(q), j, 4, 4))
    turned[:] = placements
    turned[..., 0] = x * c[..., None] + y * s[..., None]
    turned[..., 1] = y * c[..., None] - x * s[..., None]
    for slide in np.flatnonzero(slides):
        turned[:, slide] = placements[slide]
        turned[:, slide, :3, 3] += q[:, slide, None] * placements[slide, :3, 2]
    bTj = np.empty_like(turned)
    bTj[:, 0] = bTa @ turned[:, 0]
    for joint in range(1, j):
        np.matmul(bTj[:, joint - 1], turned[:, joint], out=bTj[:, joint])
    bTe = bTj[:, -1] @ lTe
    axes = np.ascontiguousarray(bTj[..., :3, 2].transpose(2, 0, 1))
    arms = bTe[:, :3, 3].T[:, :, None] - bTj[..., :3, 3].transpose(2, 0, 1)
    J = np.empty((len(q), 6, j))
    for row, (i, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        J[:, row] = axes[i] * arms[k] - axes[k] * arms[i]
        J[:, 3 + row] = axes[row]
        J[:, row, slides] = axes[row][:, slides]
        J[:, 3 + row, slides] = 0.0
    return ToolPoses(bTe[:, :3, 3], bTe[:, :3, :3], J)


@lru_cache(maxsize=8)
def _transforms(robot: RobotDescription) -> tuple[Array, Array, Array]:
    """Homogeneous bTa, placements (7, 4, 4) of every joint on the one before it, and lTe."""
    placements = [_clean(placement.homogeneous) for placement in robot.arm.joints]
    lTe = robot.arm.lTh * robot.gripper.hTe
    return robot.bTa.homogeneous, np.array(placements), lTe.homogeneous


def _clean(transform: Array) -> Array:
    """A transform without rounding errors of quarter turns."""
    whole = np.round(transform)
    return np.where(np.abs(transform - whole) < 1e-12, whole, transform)
