"""Which robots and worlds there are: a body by name or file, and what moves it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from config import UserError, suggest
from hw.background import InlineExecutor, one_thread
from hw.clock import Clock, SimClock
from hw.robot import Robot
from hw.truth import Truth
from robots import (
    RealRobot,
    RobotDescription,
    load_real_robot,
    load_robot,
    with_base_speeds,
)


class WorldError(UserError):
    """There is no world of this name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Backend:
    """A robot that can be connected, its clock, and what is known of its world."""

    robot: Robot
    clock: Clock
    truth: Truth | None
    """None where nobody knows the world."""
    world: str = ""
    """What moves the robot; empty where nothing does."""
    map: str | None = None
    """A scene that says what stands around, where the robot's file names one."""


@dataclass(frozen=True, kw_only=True)
class WorldOptions:
    """What a person may choose about a world; each world takes what concerns it."""

    scene: str
    """A shipped scene or a scene file."""
    seed: int = 0
    """Of the objects and of the camera's noise."""
    base_speed: float | None = None
    """Limit of the base [m/s]; None keeps that of the robot's description."""
    reverse_speed: float | None = None
    """The same backwards [m/s]; None keeps its share of the limit forwards."""
    paced: bool = False
    """In real time instead of as fast as it goes."""
    beside: bool = False
    """Whether images and operations take their time beside the loop, as on hardware."""
    armed: bool = False
    """Whether a person has said that a real robot may move."""
    announce: Callable[[str], None] | None = None
    """Told how fast a real robot moves, and before its hand is homed when it is connected; without
    it nothing moves then."""


def _kinematic() -> Callable[..., Robot]:
    from hw.sim import kinematic_robot

    return kinematic_robot


def _physics() -> Callable[..., Robot]:
    try:
        from hw.sim.physics import physical_robot
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise WorldError(
            'the world `physics` needs an extra: pip install "frankie-task[physics]"'
        ) from None
    return physical_robot


_SIMULATORS: Mapping[str, Callable[[], Callable[..., Robot]]] = {
    "kinematic": _kinematic,
    "physics": _physics,
}


def world_names() -> tuple[str, ...]:
    """The worlds that a robot can be put into."""
    return tuple(_SIMULATORS)


def simulator(world: str) -> Callable[..., Robot]:
    """What makes a robot out of its description, the things around it and a clock.

    Args:
        world: one of `world_names`.

    Raises:
        WorldError: there is no such world, or it needs an extra.
    """
    if world not in _SIMULATORS:
        raise WorldError(f"no world is called `{world}`; {suggest(world, _SIMULATORS)}")
    return _SIMULATORS[world]()


def _simulated(description: RobotDescription, world: str, options: WorldOptions) -> Backend:
    """A robot in the world of a scene file."""
    make = simulator(world)
    from hw.sim import load_scene

    truth = load_scene(options.scene, options.seed, description.base.size[:2])
    clock = SimClock(pace=1.0 if options.paced else None)
    robot = make(
        description,
        truth,
        clock,
        seed=options.seed,
        background=one_thread if options.beside else InlineExecutor,
    )
    return Backend(robot=robot, clock=clock, truth=truth, world=world)


def _real(real: RealRobot, world: str, options: WorldOptions) -> Backend:
    """A real robot, or one that is emulated."""
    from hw.hardware import open_hardware

    robot, clock, truth = open_hardware(
        real,
        world=world,
        scene=options.scene,
        seed=options.seed,
        armed=options.armed,
        announce=options.announce,
    )
    name = "hardware" if truth is None else "emulated"
    return Backend(robot=robot, clock=clock, truth=truth, world=name, map=real.map)


def open_backend(robot: str, world: str, options: WorldOptions) -> Backend:
    """A robot in a world, not yet connected.

    Args:
        robot: the body: name of a shipped robot, or a robot file.
        world: what moves it, where it is not real; `world_names` lists them.
        options: of the world.

    Raises:
        UserError: there is no such robot, world or scene, or its file has a mistake; a real robot
            is not armed, or commanded by another program.
        HardwareError: the emulators of a robot do not begin.
    """
    if world not in _SIMULATORS:
        raise WorldError(f"no world is called `{world}`; {suggest(world, _SIMULATORS)}")
    speeds = options.base_speed, options.reverse_speed
    if (real := load_real_robot(robot)) is not None:
        if speeds != (None, None):
            raise WorldError(f"{robot}: the limits of a real base are said in `base_limits` there")
        return _real(real, world, options)
    return _simulated(with_base_speeds(load_robot(robot), *speeds), world, options)
