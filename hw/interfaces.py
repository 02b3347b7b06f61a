"""What a robot is to the rest of the project: readings, commands, faults and one protocol."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller import Command
from robots import Intrinsics

Array = npt.NDArray[np.float64]
DepthImage = npt.NDArray[np.float32]


HAND_OPENING = 0.08
"""Distance between the finger pads of the Franka Hand when it is fully open [m]."""


class HardwareError(Exception):
    """The robot cannot be reached, read or commanded."""


class FaultKind(Enum):
    """Why a robot refuses to move."""

    REFLEX = "reflex"
    """The arm stopped itself, for example on a contact."""
    EMERGENCY_STOP = "emergency stop"
    """A person pressed the button."""
    STALE_POSE = "stale pose"
    """The base no longer knows where it is."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Something that keeps the robot from moving."""

    kind: FaultKind
    text: str
    """For people: what happened."""
    clearable: bool
    """Whether a program may clear it with `Robot.recover`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotState:
    """One consistent reading of the whole robot."""

    stamp: float
    """When it was measured, on the session's clock [s]."""
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
    faults: tuple[Fault, ...] = ()
    """Empty when healthy."""
    battery: float | None = None
    """Charge that is left, 0 to 1; None if the robot does not tell."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DepthFrame:
    """One depth image and where it was taken from."""

    depth: DepthImage
    """(H, W) depth along the optical axis [m]; NaN where missing."""
    intrinsics: Intrinsics
    wTc: SE3
    """Camera in the world at capture; z along the optical axis, x right, y down."""
    stamp: float
    """When it was captured, on the session's clock [s]."""


class Robot(Protocol):
    """A mobile manipulator with a wrist camera, simulated or real."""

    def connect(self) -> None:
        """Make ready to read and command.

        Raises:
            HardwareError: some part cannot be reached; the text says which and what to do.
        """

    def read(self) -> RobotState:
        """The newest consistent reading."""

    def send(self, command: Command) -> Command:
        """Apply velocities for one control period; returns what was really applied.

        A period without a command is a stop.
        """

    def grip(self, width: float, force: float) -> None:
        """Start moving the fingers to `width` [m], pressing with at most `force` [N]."""

    def depth(self) -> DepthFrame | None:
        """The newest depth frame, or None if there is none newer than the last one given."""

    def stop(self) -> None:
        """Come to rest as fast as limits allow. Safe in any state, from any thread."""

    def recover(self) -> None:
        """Clear the faults that a program may clear."""

    def close(self) -> None:
        """Stop and let go of the hardware. May be called twice."""
