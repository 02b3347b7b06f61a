"""What a task file names and a behaviour receives: poses, postures, regions and keys."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar, cast

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

Value = TypeVar("Value")


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
        local = np.abs((points - self.wTr.translation) @ self.wTr.rotation)
        x, y, z = self.size / 2.0
        inside: npt.NDArray[np.bool_] = (local[:, 0] <= x) & (local[:, 1] <= y) & (local[:, 2] <= z)
        return inside

    @property
    def floor(self) -> float:
        """Height of the bottom face in the world [m]."""
        return float(self.wTr.translation[2] - self.size[2] / 2.0)


class Key(Generic[Value]):
    """Where a leaf leaves what it found out, for the nodes after it.

    A leaf asks for one by a keyword-only parameter annotated `Key[int]`, a task file names it
    (`count: found`), and `$found` is then a value that later nodes may be given. A leaf that
    succeeds has written all its keys.

    Args:
        name: in the task file.
    """

    _NOTHING = object()

    def __init__(self, name: str) -> None:
        self.name = name
        self._value: object = self._NOTHING

    def write(self, value: Value) -> None:
        """Leave a value in place of the one before."""
        self._value = value

    @property
    def written(self) -> bool:
        """Whether there is a value to read."""
        return self._value is not self._NOTHING

    def read(self) -> Value:
        """The value that was written last.

        Raises:
            LookupError: nothing was; the leaf that should have is at fault.
        """
        if not self.written:
            raise LookupError(f"nothing was written to the key `{self.name}`")
        return cast(Value, self._value)
