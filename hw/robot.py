"""What a robot is to the rest of the project, and the parts that a driver author writes."""

from __future__ import annotations

from typing import Protocol, Self

from controller import Command
from hw.frame import DepthFrame, DepthImage
from hw.state import ArmState, Array, BaseState, Fault, GripperState, RobotState
from robots import RobotDescription


class HardwareError(Exception):
    """The robot cannot be reached, read or commanded."""


class Camera(Protocol):
    """The wrist camera of a robot."""

    def latest(self, max_age: float) -> DepthFrame | None:
        """The newest frame; None if there is none, or none younger than `max_age` [s].

        The same object is returned until there is a newer frame. Returns at once.
        """


class Robot(Protocol):
    """A mobile manipulator with a wrist camera, simulated or real; a context manager.

    No method but `connect` and `close` waits for the hardware: what takes time is started, and the
    readings tell when it has ended.
    """

    @property
    def description(self) -> RobotDescription:
        """What is true of it."""

    @property
    def camera(self) -> Camera:
        """The camera on its wrist."""

    def connect(self) -> None:
        """Make ready to read and command; takes the time that it takes.

        Raises:
            HardwareError: some part cannot be reached; the text says which and what to do.
        """

    def read(self) -> RobotState:
        """The newest consistent reading.

        Raises:
            HardwareError: a part does not answer any more.
        """

    def send(self, command: Command) -> Command:
        """Apply velocities for one control period; returns what was really applied.

        A period without a command is a stop.
        """

    def grip(self, width: float, force: float) -> None:
        """Start moving the fingers to `width` [m], pressing with at most `force` [N].

        `RobotState.gripper_moving` tells when they rest.
        """

    def recover(self) -> None:
        """Start to clear the faults that a program may clear.

        `RobotState.recovering` tells when that has ended.
        """

    def stop(self) -> None:
        """Come to rest as fast as limits allow. Safe in any state, from any thread."""

    def close(self) -> None:
        """Stop and let go of the hardware. May be called twice."""

    def __enter__(self) -> Self:
        """Connect."""

    def __exit__(self, *_: object) -> None:
        """Close."""


class Part(Protocol):
    """What every part of a robot can do. Reading and sending return at once."""

    def connect(self) -> None:
        """Make ready; takes the time that it takes.

        Raises:
            HardwareError: it cannot be reached.
        """

    def stop(self) -> None:
        """Come to rest as fast as limits allow. Safe in any state, from any thread."""

    def close(self) -> None:
        """Stop and let go of the hardware. May be called twice."""


class Arm(Part, Protocol):
    """An arm that follows joint velocities."""

    def read(self) -> ArmState:
        """The newest reading."""

    def send(self, qd: Array) -> Array:
        """Apply joint velocities (7,) [rad/s] for one period; returns what was really applied."""

    def recover(self) -> None:
        """Clear the faults that a program may clear; takes the time that it takes.

        Raises:
            HardwareError: they cannot be cleared.
        """


class Base(Part, Protocol):
    """A mobile base that follows a twist."""

    def read(self) -> BaseState:
        """The newest reading."""

    def send(self, twist: Array) -> Array:
        """Apply a twist (3,) in the base frame [m/s, rad/s] for one period; returns the applied."""

    def recover(self) -> None:
        """Clear the faults that a program may clear; takes the time that it takes.

        Raises:
            HardwareError: they cannot be cleared.
        """


class Gripper(Part, Protocol):
    """A parallel gripper."""

    def read(self) -> GripperState:
        """The newest reading."""

    def grip(self, width: float, force: float) -> None:
        """Move the fingers to `width` [m] with at most `force` [N]; may wait until they rest.

        Raises:
            HardwareError: the gripper does not do it.
        """

    def recover(self) -> None:
        """Clear the faults that a program may clear; takes the time that it takes.

        Raises:
            HardwareError: they cannot be cleared.
        """


class DepthCamera(Part, Protocol):
    """A depth camera."""

    def latest(self) -> DepthImage | None:
        """The newest image, the same object until there is a newer one; None before the first."""

    def faults(self) -> tuple[Fault, ...]:
        """What keeps it from delivering images; empty when healthy."""

    def recover(self) -> None:
        """Have it deliver images again; takes the time that it takes.

        Raises:
            HardwareError: it does not.
        """
