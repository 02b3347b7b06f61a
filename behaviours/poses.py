"""Poses, postures and regions that a task file names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from pinocchio import SE3


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPose:
    """A pose of the end effector in the world (`xyz`, `rpy_deg` in a task file)."""

    name: str
    wTe: SE3


@dataclass(frozen=True, kw_only=True, eq=False)
class BasePose:
    """A pose of the base on the floor (`base`, `heading_deg` in a task file)."""

    name: str
    wTb: SE3


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture:
    """Joint positions of the arm (`joints_deg` in a task file; `ready` is always there)."""

    name: str
    q: npt.NDArray[np.float64]
    """(7,) [rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Region:
    """An upright box in the world (`centre`, `size`, `yaw_deg` in a task file)."""

    name: str
    wTr: SE3
    """Centre of the box in the world, turned about z only."""
    size: npt.NDArray[np.float64]
    """(3,) full edge lengths [m]."""

    def contains(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Which of the (N, 3) world points [m] lie inside: (N,) booleans."""
        local = abs((points - self.wTr.translation) @ self.wTr.rotation)
        x, y, z = self.size / 2.0
        inside: npt.NDArray[np.bool_] = (local[:, 0] <= x) & (local[:, 1] <= y) & (local[:, 2] <= z)
        return inside

    @property
    def floor(self) -> float:
        """Height of the bottom face in the world [m]."""
        return float(self.wTr.translation[2] - self.size[2] / 2.0)
