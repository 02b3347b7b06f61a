"""Which robots and worlds there are: a body by name or file, and what moves it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from config import UserError, suggest
from hw.background import InlineExecutor, one_thread
from hw.clock import Clock, SimClock
from hw.robot import Robot
from hw.truth import Truth
from robots import RobotDescription, load_robot

if TYPE_CHECKING:
    pass


class WorldError(UserError):
    """There is no world of this name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Backend:
    """A robot that can be connected, its clock, and what is known of its world."""

    robot: Robot
    clock: Clock
    truth: Truth | None
    """None where nobody knows the world."""


@dataclass(frozen=True, kw_only=True)
class WorldOptions:
    """What a person may choose about a world; each world takes what concerns it."""

    scene: str
    """A shipped scene or a scene file."""
    seed: int = 0
    """Of the objects and of the camera's noise."""
    paced: bool = False
    """In real time instead of as fast as it goes."""
    beside: bool = False
    """Whether images and operations take their time beside the loop, as on hardware."""


def _kinematic(description: RobotDescription, options: WorldOptions) -> Backend:
    """The kinematic simulator."""
    from hw.sim import kinematic_robot

    return _simulated(description, options, kinematic_robot)


def _physics(description: RobotDescription, options: WorldOptions) -> Backend:
    """The physical simulator."""
    try:
        from hw.sim.physics import physical_robot
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise WorldError(
            'the world `physics` needs an extra: pip install "frankie-task[physics]"'
        ) from None
    return _simulated(description, options, physical_robot)


def _simulated(
    description: RobotDescription, options: WorldOptions, make: Callable[..., Robot]
) -> Backend:
    """A robot in the world of a scene file."""
    from hw.sim import load_scene

    world = load_scene(options.scene, options.seed, description.base.size[:2])
    clock = SimClock(pace=1.0 if options.paced else None)
    robot = make(
        description,
        world,
        clock,
        seed=options.seed,
        background=one_thread if options.beside else InlineExecutor,
    )
    return Backend(robot=robot, clock=clock, truth=world)


_WORLDS: dict[str, Callable[[RobotDescription, WorldOptions], Backend]] = {
    "kinematic": _kinematic,
    "physics": _physics,
}


def world_names() -> tuple[str, ...]:
    """The worlds that a robot can be put into."""
    return tuple(_WORLDS)


def open_backend(robot: str, world: str, options: WorldOptions) -> Backend:
    """A robot in a world, not yet connected.

    Args:
        robot: the body: name of a shipped robot, or a robot file.
        world: what moves it; `world_names` lists them.
        options: of the world.

    Raises:
        UserError: there is no such robot, world or scene, or its file has a mistake.
    """
    if world not in _WORLDS:
        raise WorldError(f"no world is called `{world}`; {suggest(world, _WORLDS)}")
    return _WORLDS[world](load_robot(robot), options)
