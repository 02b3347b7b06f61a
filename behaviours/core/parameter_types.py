"""Types of the parameters of leaves: keys, named poses and regions, and bounded numbers.

A task file that gives a number outside of its bounds is refused before the run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Generic, Protocol, TypeAlias, TypeVar, cast

from config.poses import MapPose, OdometryFromMap, OdometryPose

if TYPE_CHECKING:
    from config.arrays import Array, Mask
    from robots import RobotDescription

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

    def read(self) -> Value:
        """The value that was written last.

        Raises:
            LookupError: none was written.
        """
        if self._value is self._NOTHING:
            raise LookupError(f"nothing was written to the key `{self.name}`")
        return cast(Value, self._value)


class LowerBound(int):
    """A number of which there may be more: whether there are so many exactly is not known."""

    def __add__(self, more: int) -> LowerBound:
        return LowerBound(int(self) + more)

    __radd__ = __add__

    def __str__(self) -> str:
        return f"at least {int(self)}"


class MapFrame(Protocol):
    """Where the map is in odometry, by the newest estimate."""

    def oTm_on(self, piece: str) -> OdometryFromMap | None:
        """The map in odometry, for what stands on a piece of furniture; None: they are the same.

        Furniture may have been moved from its place on the map.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class MapPlace:
    """A named place on the map; a built tree has it where the map is now."""

    name: str
    on: str = ""
    """The piece of furniture with which it moves; empty for none."""
    frame: MapFrame | None = None
    """None where the map is the world."""

    @property
    def _oTm(self) -> OdometryFromMap | None:
        return None if self.frame is None else self.frame.oTm_on(self.on)

    def _placed(self, mTx: MapPose) -> OdometryPose:
        return cast("OdometryPose", mTx) if (oTm := self._oTm) is None else oTm * mTx


@dataclass(frozen=True, kw_only=True, eq=False)
class ToolPose(MapPlace):
    """A pose of the end effector on the map (`xyz`, `rpy_deg` in a task file)."""

    mTe: MapPose

    @property
    def oTe(self) -> OdometryPose:
        """In the world, now."""
        return self._placed(self.mTe)


@dataclass(frozen=True, kw_only=True, eq=False)
class BasePose(MapPlace):
    """A pose of the base on the floor (`base`, `heading_deg` in a task file)."""

    mTb: MapPose

    @property
    def oTb(self) -> OdometryPose:
        """In the world, now."""
        return self._placed(self.mTb)


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture:
    """Joint positions of the arm (`joints_deg` in a task file; `ready` is built in)."""

    name: str
    q: Array
    """(j,) [rad]; of a task file (degrees) before it is `on` a robot."""

    def on(self, robot: RobotDescription) -> Posture:
        """The same for a robot, whose sliding joints a task file has in metres."""
        import numpy as np

        if not robot.arm.slides.any() or len(self.q) != len(robot.arm.slides):
            return self
        return replace(self, q=np.where(robot.arm.slides, np.rad2deg(self.q), self.q))


@dataclass(frozen=True, kw_only=True, eq=False)
class Region(MapPlace):
    """An upright box on the map (`centre`, `size`, `yaw_deg` in a task file)."""

    mTr: MapPose
    """Centre of the box on the map, turned about z only."""
    size: Array
    """(3,) full edge lengths [m]."""
    front: float | None = None
    """Direction on the map in which the hand reaches in [rad]; None for any."""

    @property
    def oTr(self) -> OdometryPose:
        """Its centre in odometry, now."""
        return self._placed(self.mTr)

    @property
    def oTm(self) -> OdometryFromMap:
        """The map with which it moves, in odometry, now."""
        oTm: OdometryFromMap = self.oTr * self.mTr.inverse()
        return oTm

    def contains(self, points: Array) -> Mask:
        """Which of the (N, 3) points in odometry [m] lie inside: (N,) booleans."""
        local = abs((points - self.oTr.translation) @ self.oTr.rotation)
        x, y, z = self.size / 2.0
        inside: Mask = (local[:, 0] <= x) & (local[:, 1] <= y) & (local[:, 2] <= z)
        return inside

    def is_below(self, point: Array) -> bool:
        """Whether a point (3,) in odometry [m] is over its floor, or far above."""
        x, y, _ = abs(self.oTr.actInv(point))
        return bool(x <= self.size[0] / 2.0 and y <= self.size[1] / 2.0)

    def locate(self) -> Callable[[], Region]:
        """How it stands in odometry now."""
        return partial(self.at, self.oTr)

    def at(self, oTr: OdometryPose) -> Region:
        """The same in another place in odometry, where it stays."""
        return replace(self, mTr=cast("MapPose", oTr), frame=None)

    @property
    def floor(self) -> float:
        """Height of the bottom face in odometry [m]."""
        return float(self.oTr.translation[2] - self.size[2] / 2.0)


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
Tilt: TypeAlias = Annotated[float, Bounds(least=0.0, most=90.0)]  # from straight down [deg]
Deviation: TypeAlias = Annotated[float, Bounds(least=0.0, most=180.0)]  # an angle error [deg]
Force: TypeAlias = Annotated[float, Bounds(least=1.0, most=140.0)]  # of the fingers [N]
Area: TypeAlias = Annotated[float, Bounds(least=0.0, most=10_000.0)]  # of an object [cm^2]
Millimetres: TypeAlias = Annotated[float, Bounds(least=1.0, most=500.0)]  # width of an object [mm]
Pitch: TypeAlias = Annotated[float, Bounds(least=0.02, most=2.0)]  # between places [m]
