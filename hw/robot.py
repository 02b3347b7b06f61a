"""Interfaces of a robot and of its parts: arm, base, gripper, depth camera, laser."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, Self, TypeAlias, TypeVar, runtime_checkable

from controller import Command
from hw.state import (
    ArmState,
    Array,
    BaseState,
    DepthFrame,
    DepthImage,
    Fault,
    GripperState,
    LaserReading,
    LaserScan,
    RobotState,
)
from robots import RobotDescription

RECOVERY_PAUSES = (0.5, 2.0, 8.0)  # before successive recoveries from one cause [s]
RECOVERY_MEMORY = 30.0  # a recovery this long after the last is the first again [s]


class HardwareError(Exception):
    """The robot cannot be reached, read or commanded."""


Seen = TypeVar("Seen", DepthFrame, LaserScan)


@dataclass(eq=False)
class Sensor(Generic[Seen]):
    """A camera or laser: `latest(max_age)` returns at once.

    It is the newest frame or scan, the same object until there is a newer one; None if there is
    none, or none younger than `max_age` [s].
    """

    latest: Callable[[float], Seen | None]


Camera: TypeAlias = Sensor[DepthFrame]
Laser: TypeAlias = Sensor[LaserScan]


class Robot(Protocol):
    """A mobile manipulator, simulated or real; only `connect` and `close` wait for it."""

    @property
    def description(self) -> RobotDescription:
        """Its kinematics, limits, shapes and camera mount."""

    @property
    def camera(self) -> Camera:
        """The camera on its wrist."""

    @property
    def laser(self) -> Laser:
        """The laser on its base; it has no scan on a robot without one."""

    def connect(self) -> None:
        """Make ready; blocks. HardwareError: a part cannot be reached, and what to do."""

    def read(self) -> RobotState:
        """The newest consistent reading; HardwareError: a part does not answer any more."""

    def send(self, command: Command) -> Command:
        """Apply velocities for one period, then stop; returns what was really applied."""

    def grip(self, width: float, force: float) -> None:
        """Start moving the fingers to `width` [m], pressing with at most `force` [N]."""

    def recover(self) -> None:
        """Start to clear the faults that a program may clear; see `RobotState.recovering`."""

    def stop(self) -> None:
        """Come to rest as fast as limits allow. Safe in any state, from any thread."""

    def close(self) -> None:
        """Stop and release the hardware. May be called twice."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


class RobotWrapper:
    """A robot around another robot, which passes everything on; a subclass changes some of it."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot

    @property
    def description(self) -> RobotDescription:
        """See `Robot`."""
        return self._robot.description

    @property
    def camera(self) -> Camera:
        """See `Robot`."""
        return self._robot.camera

    @property
    def laser(self) -> Laser:
        """See `Robot`."""
        return self._robot.laser

    def connect(self) -> None:
        """See `Robot`."""
        self._robot.connect()

    def read(self) -> RobotState:
        """See `Robot`."""
        return self._robot.read()

    def send(self, command: Command) -> Command:
        """See `Robot`."""
        return self._robot.send(command)

    def grip(self, width: float, force: float) -> None:
        """See `Robot`."""
        self._robot.grip(width, force)

    def recover(self) -> None:
        """See `Robot`."""
        self._robot.recover()

    def stop(self) -> None:
        """See `Robot`."""
        self._robot.stop()

    def close(self) -> None:
        """See `Robot`."""
        self._robot.close()

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Part(Protocol):
    """A part of a robot. Reading and sending return at once."""

    def connect(self) -> None:
        """Make ready; blocks. HardwareError: it cannot be reached."""

    def recover(self) -> None:
        """Clear the faults that a program may clear; blocks. HardwareError: some are left."""

    def stop(self) -> None:
        """Come to rest as fast as limits allow. Safe in any state, from any thread."""

    def close(self) -> None:
        """Stop and release the hardware. May be called twice."""


@runtime_checkable
class Complaining(Protocol):
    """A part that skips messages which make no sense."""

    @property
    def complaints(self) -> tuple[str, ...]:
        """About those so far, each cause once."""


@runtime_checkable
class LeftAlone(Protocol):
    """A part that the robot's own controller has to bring to rest when commands stop."""

    def send_last(self, velocity: Array, holds: float) -> None:
        """Follow a velocity until that controller's time-out, or a stop that comes after [s]."""


@runtime_checkable
class Preparing(Protocol):
    """A part that has to move before its first use, as a hand that is homed."""

    def prepare(self, announce: Callable[[str], None]) -> None:
        """Move now, if it must, and say so before; at the beginning of a run, once connected."""


class PassivePart:
    """A part that has nothing to connect, to clear, to stop or to release."""

    def connect(self) -> None:
        """Nothing to reach."""

    def recover(self) -> None:
        """Nothing to clear."""

    def stop(self) -> None:
        """Nothing moves."""

    def close(self) -> None:
        """Nothing to release."""


class Arm(Part, Protocol):
    """An arm that follows joint velocities."""

    def read(self) -> ArmState:
        """The newest reading."""

    def send(self, qd: Array) -> Array:
        """Apply joint velocities (j,) [rad/s] for one period; returns what was really applied."""


class Base(Part, Protocol):
    """A mobile base that follows a twist."""

    def read(self) -> BaseState:
        """The newest reading."""

    def send(self, twist: Array) -> Array:
        """Apply a twist (3,) in the base frame [m/s, rad/s] for one period; returns the applied."""


class Gripper(Part, Protocol):
    """A parallel gripper."""

    def read(self) -> GripperState:
        """The newest reading."""

    def grip(self, width: float, force: float) -> None:
        """Move the fingers to `width` [m] with at most `force` [N]; raises HardwareError."""


class DepthCamera(Part, Protocol):
    """A depth camera."""

    def latest(self) -> DepthImage | None:
        """The newest image, the same object until there is a newer one; None before the first."""

    def faults(self) -> tuple[Fault, ...]:
        """What keeps it from delivering images; empty when healthy."""


class LaserScanner(Part, Protocol):
    """A laser."""

    def latest(self) -> LaserReading | None:
        """The newest scan, the same object until there is a newer one; None before the first."""
