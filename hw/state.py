"""What a robot tells: the state of each part, of the whole, and what keeps it from moving."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

Array = npt.NDArray[np.float64]


class FaultKind(Enum):
    """Why a robot refuses to move."""

    REFLEX = "reflex"
    """The arm stopped itself, for example on a contact."""
    BUMPER = "bumper"
    """The base stopped itself on a contact."""
    EMERGENCY_STOP = "emergency stop"
    """A person pressed the button."""
    STALE_POSE = "stale pose"
    """The base no longer knows where it is."""
    CONNECTION = "connection lost"
    """A part of the robot does not answer any more."""
    NOT_READY = "not ready"
    """Motors are off, or something else has the robot: a mode that is locked, another program."""
    OPERATION = "operation failed"
    """A gripper motion or a recovery ended with an error."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Something that keeps the robot from moving."""

    kind: FaultKind
    text: str
    """For people: what happened."""
    clearable: bool
    """Whether a program may clear it with `Robot.recover`."""
    bearing: float | None = None
    """Where the base was touched, seen from its centre: 0 ahead, positive to the left [rad]; None
    where the robot does not tell."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArmState:
    """A reading of the arm."""

    stamp: float
    """When it was measured, on the session's clock [s]."""
    q: Array
    """(7,) joint positions [rad]."""
    qd: Array
    """(7,) joint velocities [rad/s]."""
    faults: tuple[Fault, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class BaseState:
    """A reading of the base."""

    stamp: float
    """When it was measured, on the session's clock [s]."""
    wTb: SE3
    """Localised pose in the world."""
    twist: Array
    """(3,) vx, vy, ω in the base frame [m/s, m/s, rad/s]."""
    battery: float | None = None
    """Charge that is left, 0 to 1; None if the robot does not tell."""
    faults: tuple[Fault, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class GripperState:
    """A reading of the gripper."""

    stamp: float
    """When it was measured, on the session's clock [s]."""
    width: float
    """Distance between the finger pads [m]."""
    moving: bool
    """Whether the last grip is still under way."""
    faults: tuple[Fault, ...] = ()


class PartStamps(NamedTuple):
    """When the newest reading of each part was measured, on the session's clock [s]."""

    arm: float
    base: float
    gripper: float


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotState:
    """The whole robot at one moment: arm and base interpolated to a common stamp."""

    stamp: float
    """Of arm and base: when the older of their newest readings was measured, on the session's
    clock [s]."""
    wTb: SE3
    """Localised base pose in the world."""
    base_twist: Array
    """(3,) vx, vy, ω in the base frame [m/s, m/s, rad/s]."""
    q: Array
    """(7,) arm joint positions [rad]."""
    qd: Array
    """(7,) arm joint velocities [rad/s]."""
    gripper_width: float
    """Distance between the finger pads [m]."""
    gripper_moving: bool
    """Whether the last grip is still under way."""
    recovering: bool = False
    """Whether a recovery is still under way."""
    faults: tuple[Fault, ...] = ()
    """Empty when healthy."""
    battery: float | None = None
    """Charge that is left, 0 to 1; None if the robot does not tell."""
    stamps: PartStamps | None = None
    """Of the parts' own newest readings; None where the parts are not told apart."""


def interpolate_arm(a: ArmState, b: ArmState, stamp: float) -> ArmState:
    """The arm between two readings, linearly; faults are those of the later one."""
    s = (stamp - a.stamp) / (b.stamp - a.stamp)
    return ArmState(
        stamp=stamp, q=a.q + s * (b.q - a.q), qd=a.qd + s * (b.qd - a.qd), faults=b.faults
    )


def interpolate_base(a: BaseState, b: BaseState, stamp: float) -> BaseState:
    """The base between two readings, along the screw from one pose to the other."""
    s = (stamp - a.stamp) / (b.stamp - a.stamp)
    return BaseState(
        stamp=stamp,
        wTb=SE3.Interpolate(a.wTb, b.wTb, s),
        twist=a.twist + s * (b.twist - a.twist),
        battery=b.battery,
        faults=b.faults,
    )
