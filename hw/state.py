"""Readings of a robot: state of arm, base, gripper and whole robot, depth images, and faults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from config.arrays import Array
from config.poses import MapPose, OdometryPose
from robots import Intrinsics

if TYPE_CHECKING:
    from perception import DepthCloud

DepthArray = npt.NDArray[np.float32]
ColourArray = npt.NDArray[np.uint8]
Paint: TypeAlias = Callable[[], ColourArray]  # renders the colours of an image, on demand


class FaultKind(Enum):
    """Why a robot refuses to move."""

    REFLEX = "reflex"  # the arm stopped itself, for example on a contact
    BUMPER = "bumper"  # the base stopped itself on a contact
    EMERGENCY_STOP = "emergency stop"  # a person pressed the button
    STALE_POSE = "stale pose"  # the base has lost its localisation
    LOST = "lost"  # nothing in sight is where the map has it
    CONNECTION = "connection lost"  # a part of the robot does not answer any more
    NOT_READY = "not ready"  # motors are off, the mode is locked, or another program has control
    OPERATION = "operation failed"  # a gripper motion or a recovery ended with an error


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A condition that keeps the robot from moving."""

    kind: FaultKind
    text: str  # for people: what happened
    clearable: bool  # whether a program may clear it with `Robot.recover`
    bearing: float | None = None
    """Direction of a touch of the base, seen from its centre: 0 ahead, positive to the left [rad];
    None where the robot does not report it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmState:
    """A reading of the arm. All stamps here are on the session's clock [s]."""

    stamp: float
    q: Array  # (j,) joint positions [rad]
    qd: Array  # (j,) joint velocities [rad/s]
    faults: tuple[Fault, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalisedPose:
    """One pose of the base on the map; the same object is the same measurement."""

    stamp: float  # of the measurement [s]
    mTb: MapPose
    covariance: Array  # (3, 3) of x, y and yaw on the map [m², m rad, rad²]
    source: str = "the base's own localisation"  # who tells it, for people


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseState:
    """A reading of the base."""

    stamp: float
    oTb: OdometryPose  # in odometry: odometry, or localised where that is not told apart
    twist: Array  # (3,) vx, vy, ω in the base frame [m/s, m/s, rad/s]
    battery: float | None = None  # charge, 0 to 1; None if the robot does not report it
    faults: tuple[Fault, ...] = ()
    localised: LocalisedPose | None = None  # newest; None where `oTb` is localised, and if lost


@dataclass(frozen=True, kw_only=True, eq=False)
class GripperState:
    """A reading of the gripper."""

    stamp: float
    width: float  # distance between the finger pads [m]
    moving: bool  # whether the last grip is still in progress
    faults: tuple[Fault, ...] = ()


class PartStamps(NamedTuple):
    """When the newest reading of each part was measured [s]."""

    arm: float
    base: float
    gripper: float


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotState:
    """The whole robot at one moment: arm and base interpolated to a common stamp."""

    stamp: float  # of arm and base: the older of their newest readings [s]
    oTb: OdometryPose  # base in odometry: odometry, or localised where that is not told apart
    base_twist: Array  # (3,) vx, vy, ω in the base frame [m/s, m/s, rad/s]
    q: Array  # (j,) arm joint positions [rad]
    qd: Array  # (j,) arm joint velocities [rad/s]
    gripper_width: float  # distance between the finger pads [m]
    gripper_moving: bool  # whether the last grip is still in progress
    recovering: bool = False  # whether a recovery is still in progress
    faults: tuple[Fault, ...] = ()  # empty when healthy
    battery: float | None = None  # charge, 0 to 1; None if the robot does not report it
    localised: LocalisedPose | None = None  # newest; None where `oTb` is localised, and if lost
    stamps: PartStamps | None = None  # None where the parts are not read separately
    complaints: tuple[str, ...] = ()  # about messages that the parts have skipped so far


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthImage:
    """One image as a camera delivers it; the same object is the same image."""

    depth: DepthArray  # (H, W) depth along the optical axis [m]; NaN where missing
    stamp: float  # of the capture [s]
    paint: Paint | None = None  # None if the camera has no colours


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthFrame:
    """One depth image and where it was captured; the same object is the same frame."""

    depth: DepthArray  # (H, W) depth along the optical axis [m]; NaN where missing
    intrinsics: Intrinsics
    oTc: OdometryPose  # camera in odometry at capture; z along the optical axis, x right, y down
    stamp: float  # of the capture [s]
    paint: Paint | None = None  # None if the camera has no colours

    @cached_property
    def colour(self) -> ColourArray | None:
        """(H, W, 3) red, green and blue of the same pixels, 0 to 255; None if there are none."""
        return None if self.paint is None else self.paint()

    @cached_property
    def cloud(self) -> DepthCloud:
        """Its points in odometry, shared by all who look at it."""
        from perception import DepthCloud  # not at the top: a driver's process needs none

        depth = np.asarray(self.depth, dtype=np.float32)
        return DepthCloud(depth=depth, intrinsics=self.intrinsics, oTc=self.oTc)


@dataclass(frozen=True, kw_only=True, eq=False)
class LaserReading:
    """One scan as a laser delivers it; the same object is the same scan."""

    stamp: float  # of the capture [s]
    ranges: Array  # (n,) from the laser [m]; inf: nothing is in reach, NaN: the beam tells nothing
    points: Array  # (n, 3) ends of the beams in the base [m]; NaN where one tells nothing


@dataclass(frozen=True, kw_only=True, eq=False)
class LaserScan(LaserReading):
    """One scan and where it was captured; the same object is the same scan."""

    oTb: OdometryPose  # base in odometry at capture
