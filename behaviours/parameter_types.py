"""Types of the parameters of leaves: keys, named poses and regions, and bounded numbers.

A task file that gives a number outside of its bounds is refused before the run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Generic, TypeAlias, TypeVar, cast

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from pinocchio import SE3

Value = TypeVar("Value")


class Key(Generic[Value]):
    """Where a leaf writes a result for later nodes; an entry of the tree's blackboard.

    A leaf asks for one by a keyword-only parameter annotated `Key[int]`, a task file names it
    (`count: found`), and `$found` is then a value for later nodes. A leaf that succeeds has written
    all its keys.

    Args:
        name: in the task file.
    """

    _NOTHING = object()

    def __init__(self, name: str) -> None:
        self.name = name
        self._value: object = self._NOTHING

    def write(self, value: Value) -> None:
        """Replace the value."""
        self._value = value

    @property
    def written(self) -> bool:
        """Whether there is a value to read."""
        return self._value is not self._NOTHING

    def read(self) -> Value:
        """The value that was written last.

        Raises:
            LookupError: none was written.
        """
        if not self.written:
            raise LookupError(f"nothing was written to the key `{self.name}`")
        return cast(Value, self._value)


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
    """Joint positions of the arm (`joints_deg` in a task file; `ready` is built in)."""

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


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Bounds of a number, as in `Annotated[float, Bounds(least=0.0)]`."""

    above: float | None = None
    """Exclusive minimum."""
    least: float | None = None
    most: float | None = None


Positive: TypeAlias = Annotated[float, Bounds(above=0.0)]
NotNegative: TypeAlias = Annotated[float, Bounds(least=0.0)]
Percent: TypeAlias = Annotated[float, Bounds(least=0.0, most=100.0)]
Count: TypeAlias = Annotated[int, Bounds(least=1, most=1000)]
Timeout: TypeAlias = Annotated[float, Bounds(above=0.0, most=86_400.0)]  # [s]
Duration: TypeAlias = Annotated[float, Bounds(least=0.0, most=86_400.0)]  # [s]
Distance: TypeAlias = Annotated[float, Bounds(above=0.0, most=2.0)]  # within reach of the arm [m]
Lift: TypeAlias = Annotated[float, Bounds(least=0.0, most=1.0)]  # of the hand [m]
Speed: TypeAlias = Annotated[float, Bounds(least=0.01, most=2.0)]  # [m/s]
BaseDistance: TypeAlias = Annotated[float, Bounds(least=-20.0, most=20.0)]  # forwards [m]
Turn: TypeAlias = Annotated[float, Bounds(least=-360.0, most=360.0)]  # to the left [deg]
Deviation: TypeAlias = Annotated[float, Bounds(least=0.0, most=180.0)]  # an angle error [deg]
Force: TypeAlias = Annotated[float, Bounds(least=1.0, most=140.0)]  # of the fingers [N]
Area: TypeAlias = Annotated[float, Bounds(least=0.0, most=10_000.0)]  # of an object [cm^2]
Millimetres: TypeAlias = Annotated[float, Bounds(least=1.0, most=500.0)]  # width of an object [mm]
Pitch: TypeAlias = Annotated[float, Bounds(least=0.02, most=2.0)]  # between places [m]
