"""Registry of robots and worlds: chooses the driver or simulator of a robot."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import distributions

from config import UserError, extra, suggest
from hw.clock import Clock, SimClock, WallClock, Worker
from hw.robot import Robot
from hw.truth import Truth
from robots import RobotDescription, load_real_robot, load_robot, with_base_speeds


class WorldError(UserError):
    """No world of this name, or it needs an extra."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Backend:
    """A robot ready to connect, its clock, and the truth of its world."""

    robot: Robot
    clock: Clock
    truth: Truth | None  # None on hardware
    world: str = ""  # what moves the robot; may be empty
    map: str | None = None  # scene of the surroundings, from the robot's file


@dataclass(frozen=True, kw_only=True)
class WorldOptions:
    """Options of a world; each world takes what concerns it."""

    scene: str  # shipped scene or a scene file
    seed: int = 0  # of the objects and the camera's noise
    base_speed: float | None = None  # limit [m/s]; None keeps that of the robot
    reverse_speed: float | None = None  # the same backwards; None keeps its share
    localisation: str | None = "exact"  # how wrong a simulated robot is; None: as `DEFAULT_LEVEL`
    paced: bool = False  # not faster than real time
    real_clock: bool = False  # a simulated robot that does not wait for its loop, as a real one
    armed: bool = False  # a person has allowed a real robot to move
    announce: Callable[[str], None] | None = None
    """Told the speed of a real robot, and before its hand is homed at connecting; without it the
    hand is not homed."""


_RENDERING = 0.02  # from the capture of an image to its arrival [s]
WORLDS = ("kinematic", "physics")  # the simulated worlds, by name
DEFAULT_LEVEL = "good"  # how wrong a simulated robot is about where it is, unless said


def simulator(world: str) -> Callable[..., Robot]:
    """The factory of a simulated robot in one of `WORLDS`; WorldError: it needs an extra."""
    if world == "kinematic":
        from hw.sim import kinematic_robot

        return kinematic_robot
    try:
        from hw.sim.physics import physical_robot
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise WorldError(f"the world `physics` needs an extra: {extra('physics')}") from None
    _check_engine()
    return physical_robot


_ENGINES = "mujoco-core", "mujoco"


def _check_engine() -> None:
    """Refuse an engine that is another one than its package says: two packages write one folder."""
    import mujoco

    there = {one.name: one.version for one in distributions() if one.name in _ENGINES}
    if set(there.values()) != {mujoco.__version__} or not mujoco.__version__.startswith("4.0."):
        told = ", ".join(f"{name} {number}" for name, number in there.items())
        raise WorldError(
            f"the world `physics` needs one MuJoCo 4.0, here is {mujoco.__version__} of {told}, "
            'which share a folder: pip uninstall mujoco mujoco-core; pip install "mujoco==4.0.*" '
            '"frankie-task[physics]"'
        )


def open_backend(robot: str, world: str, options: WorldOptions) -> Backend:
    """A robot in one of `WORLDS`, or a real one, not yet connected.

    UserError: there is no such robot, world or scene, or a file has a mistake; a real robot is
    not armed, or is commanded. HardwareError: the emulators of a robot do not start.
    """
    if world not in WORLDS:
        raise WorldError(f"no world is called `{world}`; {suggest(world, WORLDS)}")
    speeds = options.base_speed, options.reverse_speed
    if (real := load_real_robot(robot)) is None:
        return _simulated(with_base_speeds(load_robot(robot), *speeds), world, options)
    if speeds != (None, None):
        raise WorldError(f"{robot}: the limits of a real base are said in `base_limits` there")
    if options.localisation not in (None, "exact") and real.hardware.emulated is None:
        raise WorldError(f"{robot}: a real robot cannot be made wrong about where it is")
    from hw.hardware import open_hardware

    return open_hardware(real, world, options)


def _simulated(description: RobotDescription, world: str, options: WorldOptions) -> Backend:
    make = simulator(world)
    if world == "physics" and not description.arm.inertias:
        hint = "write `inertia` in the file of its arm, or take the world `kinematic`"
        raise WorldError(f"the links of {description.name} have no inertias; {hint}")
    from hw.sim import load_localisation, load_scene

    level = load_localisation(options.localisation or DEFAULT_LEVEL)
    truth = load_scene(options.scene, options.seed, description.base.size[:2], level.moved)
    clock: Clock = WallClock() if options.real_clock else SimClock(paced=options.paced)
    robot = make(
        description,
        truth,
        clock,
        seed=options.seed,
        localisation=level,
        rendering=Worker(clock, _RENDERING),
    )
    return Backend(robot=robot, clock=clock, truth=truth, world=world)
