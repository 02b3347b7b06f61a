"""The parts of a real robot, made by the drivers that its file names."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from config import DoorError, UserError
from hw.clock import Clock
from hw.robot import HardwareError
from robots import (
    KINDS,
    DriverOptions,
    RealRobot,
    RobotDescription,
    find_driver,
    has_driver,
)


@dataclass(frozen=True, kw_only=True)
class DriverContext:
    """What a driver is told besides its options."""

    robot: RobotDescription
    clock: Clock  # on which readings are stamped
    parts: Mapping[str, Any] = field(default_factory=dict)
    """Parts of the same robot that were made before, by their kinds, in the order of `KINDS`."""
    emulator: str = ""  # HOST:PORT of the emulated camera; empty on a real robot
    file: RealRobot | None = None  # the robot's file, where it has one
    scene: str = ""  # of the run, for what is simulated; empty without a run
    seed: int = 0


def parts_of(
    real: RealRobot, robot: RobotDescription, clock: Clock, scene: str = "", seed: int = 0
) -> dict[str, Any]:
    """The parts of a real robot by their kinds, not yet connected; DoorError: there is no such.

    HardwareError: one cannot be made.
    Without a driver of its own the laser is that of the base, if that has one without options.
    """
    parts: dict[str, Any] = {}
    hardware, emulator = real.hardware, ""
    if hardware.emulated is not None:
        emulator = f"{getattr(hardware.base, 'address', '')}:{hardware.emulated + 1}"
    context = DriverContext(
        robot=robot,
        clock=clock,
        parts=parts,
        emulator=emulator,
        file=real,
        scene=scene,
        seed=seed,
    )
    for kind, name, options in _drivers(real, robot):
        driver = find_driver(kind, name)
        try:
            parts[kind] = driver.make(options, context)
        except (HardwareError, UserError):
            raise
        except Exception as error:  # whatever somebody's driver raises
            raise HardwareError(f"{kind}: `{name}` cannot be made: {one_line(error)}") from error
    return parts


def one_line(error: BaseException) -> str:
    """What was raised, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def _drivers(real: RealRobot, robot: RobotDescription) -> Iterator[tuple[str, str, Any]]:
    """Kind, driver and options of each part."""
    for kind in KINDS:
        options = getattr(real.hardware, kind)
        if options is None and robot.laser is not None:
            options = _laser_of(real.hardware.base.driver)
        if options is not None and kind == "laser" and robot.laser is None:
            raise DoorError(f"{real.path}: hardware.laser: {real.body} describes no laser")
        if options is not None:
            yield kind, options.driver, options


def _laser_of(base: str) -> DriverOptions | None:
    """The laser over the connection of a base, whose driver has no options of its own."""
    is_there = has_driver("laser", base) and find_driver("laser", base).options is DriverOptions
    return DriverOptions(driver=base) if is_there else None
