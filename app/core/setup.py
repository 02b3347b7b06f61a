"""Setup of a session: connects the robot; makes world model, controller, gate, vision, context."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from app.choices import ObstacleSource, Speed
from app.run_options import DEFAULT_SCENE, RunOptions
from behaviours import (
    Around,
    Context,
    DepthObstacles,
    MapSensors,
    Now,
    Vision,
    map_surfaces,
)
from controller import HolisticController, Obstacle, RobotModel, Surroundings
from hw import (
    Backend,
    Clock,
    Gate,
    HardwareError,
    Injector,
    RecordedRobot,
    Robot,
    RobotState,
    TaskClock,
    Truth,
    Worker,
    WorldOptions,
    open_backend,
)
from perception import GraspDetector
from robots import Geom, Plane

_SEARCH = 0.03  # simulated duration of a search for grasps [s] ...
_REGISTRATION = 0.03  # ... of a registration ...
_DEPTH_OBSTACLES = 0.03  # ... and of the obstacles in a frame
_NOWHERE = ("", "hand", "floor")


class WorldModel(NamedTuple):
    """What the robot is given of its surroundings."""

    fixtures: tuple[Geom, ...] = ()  # static geometry in the world frame, without the floor
    obstacles: Callable[[float], Sequence[Obstacle]] = lambda stamp: ()
    """Moving obstacles at a time on the session's clock [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What a session works with; the robot is connected."""

    robot: RecordedRobot
    injector: Injector | None  # of faults
    clock: TaskClock
    truth: Truth | None  # state of the simulated world; None on hardware
    world: str  # what simulates the robot
    of_scene: bool  # whether its furniture is that of scene and seed
    map: str  # file of the furniture; empty: what is simulated, or none
    controller: HolisticController
    gate: Gate
    context: Context
    problems: list[str]  # errors while everything is closed


@contextmanager
def open_setup(
    options: RunOptions,
    detector: GraspDetector,
    *,
    opened: Callable[[Backend], Backend] = lambda backend: backend,
    control: Callable[[RobotModel], HolisticController] = HolisticController,
    announce: Callable[[str], None] | None = None,
) -> Iterator[Setup]:
    """Connect the robot of a run in its world, see `set_up`; `announce` is that of the world.

    `opened` may change what was opened, `control` makes the controller. Raises:
        UserError: there is no such robot, world or scene, or its file has a mistake.
        HardwareError: the robot cannot be connected.
    """
    world = WorldOptions(
        scene=options.scene or DEFAULT_SCENE,
        seed=options.seed,
        base_speed=options.base_speed,
        reverse_speed=options.reverse_speed,
        localisation=options.localisation,
        paced=options.speed is Speed.REAL,
        real_clock=options.real_clock,
        armed=options.armed,
        announce=announce,
    )
    backend = opened(open_backend(options.robot, options.world, world))
    try:
        around = load_world_model(backend.truth, options.map or backend.map)
    except BaseException:
        backend.robot.close()  # it is claimed already
        raise
    with set_up(backend, detector, options, world_model=around, control=control) as setup:
        yield setup


@contextmanager
def set_up(
    backend: Backend,
    detector: GraspDetector,
    options: RunOptions,
    *,
    world_model: WorldModel,
    control: Callable[[RobotModel], HolisticController] = HolisticController,
) -> Iterator[Setup]:
    """Connect a robot and set up a session; close everything at the end of the context.

    `control` makes the controller. Raises HardwareError: the robot cannot be connected.
    """
    robot = RecordedRobot(backend.robot, backend.clock)
    problems: list[str] = []
    if options.obstacles is ObstacleSource.CAMERA:
        world_model = WorldModel()
    sees = options.obstacles is not ObstacleSource.MAP
    with (
        _connected(robot, problems) as state,
        _worker(robot.clock, _SEARCH) as search,
        _worker(robot.clock, _REGISTRATION) as registration,
        _worker(robot.clock, _DEPTH_OBSTACLES) if sees else nullcontext() as depth,
    ):
        clock = TaskClock(robot.clock, robot.description.pace)
        controller = control(RobotModel(robot.description))
        moving = tuple(world_model.obstacles(state.stamp))
        controller.prepare(Surroundings(fixtures=world_model.fixtures, moving=moving))
        vision = Vision(robot.camera, detector, search)
        around = Around(
            fixtures=world_model.fixtures,
            obstacles=world_model.obstacles,
            depth_obstacles=DepthObstacles(robot.description, depth) if sees else None,
        )
        surfaces = map_surfaces(world_model.fixtures)
        yield Setup(
            robot=robot,
            injector=backend.injector,
            clock=clock,
            truth=backend.truth,
            world=backend.world,
            of_scene=backend.of_scene,
            map=str(options.map or backend.map or ""),
            controller=controller,
            gate=Gate(robot, robot.description, controller.settings.period),
            context=Context(
                robot=robot,
                model=controller.model,
                clock=clock,
                vision=vision,
                now=Now(state=state),
                around=around,
                map_sensors=MapSensors(surfaces, options.registration.sensors, registration),
            ),
            problems=problems,
        )


@contextmanager
def _worker(clock: Clock, seconds: float) -> Iterator[Worker]:
    """A thread for work that takes so long in simulated time [s]."""
    worker = Worker(clock, seconds)
    try:
        yield worker
    finally:
        worker.shutdown(wait=False, cancel_futures=True)


@contextmanager
def _connected(robot: Robot, problems: list[str]) -> Iterator[RobotState]:
    """Connect a robot and yield its first reading; errors of closing go to `problems`.

    Raises HardwareError: it cannot be connected or read.
    """
    try:
        try:
            robot.connect()
            state = robot.read()
        except HardwareError:
            raise
        except Exception as error:
            reason = f"the robot cannot be connected ({type(error).__name__}: {error})"
            raise HardwareError(reason) from error
        yield state
    finally:
        try:
            robot.close()
        except Exception as error:
            problems.append(f"closing the robot failed ({type(error).__name__}: {error})")


def load_world_model(truth: Truth | None, site: Path | str | None = None) -> WorldModel:
    """The map of a site, or that of a simulated world, and its moving obstacles.

    `site` is a scene file with the map; None takes the map of the simulated world. Raises
    SceneError: the file is missing or has a mistake.
    """
    if site is not None:
        from hw.sim import load_fixtures

        fixtures: Sequence[Geom] = load_fixtures(site)
    else:
        fixtures = truth.mapped if truth else ()
    solid = tuple(one for one in fixtures if not isinstance(one.shape, Plane))
    return WorldModel(solid, lambda stamp: truth.moving() if truth else ())


def recorded_world_model(scene: str | None, seed: int, site: Path | None) -> WorldModel:
    """The world model of a finished run, recomputed from its scene and seed if it has one.

    Raises SceneError: the scene or map is missing or has a mistake.
    """
    from hw.sim import load_scene

    if scene is None:
        return load_world_model(None, site)
    world = load_scene(scene, seed)

    def obstacles(stamp: float) -> Sequence[Obstacle]:
        world.move_to(stamp)
        return world.moving()

    return load_world_model(world, site)._replace(obstacles=obstacles)


def supports(truth: Truth | None) -> Mapping[str, str]:
    """Name of what carries each simulated object; empty on hardware."""
    return truth.supports() if truth else {}


def delivered(before: Mapping[str, str], after: Mapping[str, str]) -> int:
    """Number of objects that stand on other furniture, by `supports` at the beginning and end."""
    return sum(after[name] not in (*_NOWHERE, before[name]) for name in before)
