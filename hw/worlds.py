"""Worlds: what moves a robot. Packages offer them as entry points of `frankie_task.worlds`.

A world is a function of a robot, a name or a file, and of `WorldOptions`; it returns a `Backend`
whose robot is not yet connected, as `ComposedRobot` of parts. `run --world NAME:ARGUMENT` asks for
it. The hardware of a robot file is the world `hardware`, or `emulated` where it names emulators.
Only a world that says `is_wrapper = True` gets such a file, too, and hands it to `open_backend`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import Protocol

from config import UserError, entries, find, suggest
from hw.clock import Clock
from hw.robot import Robot
from hw.truth import Truth
from robots import load_real_robot

GROUP = "frankie_task.worlds"
DEFAULT_LEVEL = "good"  # how wrong a simulated robot is about where it is, unless said
_OF_FILES = ("emulated", "hardware")  # which a robot file asks for


class WorldError(UserError):
    """A world cannot be had as it is asked for."""


class Injector(Protocol):
    """Gives a robot faults, from any thread."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the faults that it has here."""

    def inject(self, name: str, duration: float = inf) -> None:
        """Give a fault from the next reading on, for a time [s]; UserError: there is none such."""

    def clear(self, name: str | None = None) -> None:
        """End a fault, or all, from the next reading on."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Backend:
    """A robot ready to connect, its clock, and the truth of its world."""

    robot: Robot
    clock: Clock
    truth: Truth | None  # None on hardware
    world: str = ""  # what moves the robot; may be empty
    map: str | None = None  # scene file of the surroundings, from the robot's file
    of_scene: bool = False  # whether its fixtures are those of the scene and seed in the options
    injector: Injector | None = None  # of a robot that can be given faults


@dataclass(frozen=True, kw_only=True)
class WorldOptions:
    """Options of a world; each world takes what concerns it."""

    scene: str  # shipped scene or a scene file
    seed: int = 0  # of the objects and the camera's noise
    name: str = "kinematic"  # what was asked for ...
    argument: str = ""  # ... and what stood behind the colon
    base_speed: float | None = None  # limit [m/s]; None keeps that of the robot
    reverse_speed: float | None = None  # the same backwards; None keeps its share
    localisation: str | None = "exact"  # how wrong a simulated robot is; None: as `DEFAULT_LEVEL`
    paced: bool = False  # not faster than real time
    real_clock: bool = False  # a simulated robot that does not wait for its loop, as a real one
    armed: bool = False  # a person has allowed a real robot to move
    announce: Callable[[str], None] | None = None
    """Told the speed of a real robot, and before its hand is homed at connecting; without it the
    hand is not homed."""


class World(Protocol):
    """What an entry point offers."""

    def __call__(self, robot: str, options: WorldOptions) -> Backend:
        """A robot by name or file, not yet connected, in this world."""


def world_names() -> list[str]:
    """The installed worlds that `--world` may name."""
    return sorted({entry.name for entry in entries(GROUP)}.difference(_OF_FILES))


def find_world(name: str) -> World:
    """A world by its name; DoorError: there is none, or its package is broken."""
    world = find(GROUP, name, "world")
    if not callable(world):
        raise WorldError(f"the world `{name}` is no function; fix its package")
    return world


def open_backend(robot: str, world: str, options: WorldOptions) -> Backend:
    """A robot in a world, `NAME` or `NAME:ARGUMENT`, or a real one, not yet connected.

    UserError: there is no such robot, world or scene, or a file has a mistake; a real robot is
    not armed, or is commanded. HardwareError: the emulators of a robot do not start.
    """
    name, _, argument = world.partition(":")
    if name in _OF_FILES:
        raise WorldError(f"--world {name}: a robot file with `hardware` says so: --robot FILE")
    if name not in (known := world_names()):
        raise WorldError(f"no world is called `{name}`; {suggest(name, known)}")
    simulated = find_world(name)
    options = replace(options, name=name, argument=argument)
    if (real := load_real_robot(robot)) is None or getattr(simulated, "is_wrapper", False):
        return simulated(robot, options)
    if (options.base_speed, options.reverse_speed) != (None, None):
        raise WorldError(f"{robot}: the limits of a real base are said in `base_limits` there")
    if options.localisation not in (None, "exact") and real.hardware.emulated is None:
        raise WorldError(f"{robot}: a real robot cannot be made wrong about where it is")
    return find_world("hardware" if real.hardware.emulated is None else "emulated")(robot, options)
