"""Setup of a session: connects the robot, and makes controller, gate, vision and context."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import datetime

from py_trees.behaviour import Behaviour

from app.choices import MotionForm, ObstacleSource
from app.core.decisions import Decisions
from app.core.measurements import Measurements
from app.core.outcome import Outcome
from app.core.run_options import DEFAULT_SCENE, RunOptions
from app.core.session import Session, Tick
from app.core.world_model import WorldModel, load_world_model
from behaviours import (
    Context,
    DepthObstacles,
    Localiser,
    Vision,
    map_surfaces,
)
from controller import (
    HolisticController,
    MotionController,
    PlanningController,
    PlanningSettings,
    RobotModel,
    Surroundings,
)
from hw import (
    Backend,
    FaultInjection,
    Gate,
    HardwareError,
    RecordedRobot,
    Robot,
    RobotState,
    TaskClock,
    Truth,
    Worker,
    WorldOptions,
    epoch,
    open_backend,
)
from perception import GraspDetector

_NOON = 43_200.0  # [s since midnight]
_SEARCH = 0.03  # simulated duration of a search for grasps [s] ...
_REGISTRATION = 0.03  # ... of a registration ...
_DEPTH_OBSTACLES = 0.03  # ... and of the obstacles in a frame


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What a session works with; the robot is connected."""

    robot: FaultInjection
    recorded: RecordedRobot  # the same robot, as the loop sees it
    clock: TaskClock
    truth: Truth | None  # state of the simulated world; None on hardware
    world: str  # what simulates the robot
    map: str  # file of the furniture; empty: what is simulated, or none
    controller: MotionController
    gate: Gate
    vision: Vision
    context: Context
    problems: list[str]  # errors while everything is closed

    @property
    def model(self) -> RobotModel:
        """The robot's kinematics; used by the loop only."""
        return self.controller.model

    def session(
        self,
        root: Behaviour,
        control: Decisions,
        watch: Callable[[Tick], None] = lambda tick: None,
        measurements: Measurements | None = None,
        abandon: Callable[[Outcome], None] = lambda outcome: None,
    ) -> Session:
        """A session for a built tree, see `Session`."""
        return Session(
            root=root,
            context=self.context,
            controller=self.controller,
            gate=self.gate,
            measurements=measurements or Measurements(limits=self.model.limits),
            clock=self.clock,
            control=control,
            watch=watch,
            abandon=abandon,
        )


@contextmanager
def open_setup(
    options: RunOptions,
    detector: GraspDetector,
    *,
    beneath: Callable[[Robot], Robot] = lambda robot: robot,
    announce: Callable[[str], None] | None = None,
) -> Iterator[Setup]:
    """Connect the robot of a run in its world, see `set_up`; `announce` is that of the world.

    Raises:
        PlanningError: motions are to be planned, and the planner is not installed.
        UserError: there is no such robot, world or scene, or its file has a mistake.
        HardwareError: the robot cannot be connected.
    """
    world = WorldOptions(
        scene=options.scene or DEFAULT_SCENE,
        seed=options.seed,
        base_speed=options.base_speed,
        reverse_speed=options.reverse_speed,
        localisation=options.localisation,
        paced=options.paced,
        real_clock=options.real_clock,
        armed=options.armed,
        announce=announce,
    )
    backend = open_backend(options.robot, options.world, world)
    try:
        around = load_world_model(backend.truth, options.map or backend.map)
    except BaseException:
        backend.robot.close()  # it is claimed already
        raise
    with set_up(backend, detector, options, world_model=around, beneath=beneath) as setup:
        yield setup


@contextmanager
def set_up(
    backend: Backend,
    detector: GraspDetector,
    options: RunOptions,
    *,
    world_model: WorldModel,
    beneath: Callable[[Robot], Robot] = lambda robot: robot,
) -> Iterator[Setup]:
    """Connect a robot and set up a session; close everything at the end of the context.

    `beneath` wraps the robot below the fault injection. Raises PlanningError: motions are to be
    planned, and the planner is not installed; HardwareError: the robot cannot be connected.
    """
    motion, registered = options.motion, options.registration.sensors
    injected = FaultInjection(beneath(backend.robot), backend.truth, options.seed)
    robot = RecordedRobot(injected, backend.clock)
    problems: list[str] = []
    if options.obstacles is ObstacleSource.CAMERA:
        world_model = WorldModel()
    with (
        _connected(robot, problems) as state,
        closing(Vision(robot.camera, detector, Worker(robot.clock, _SEARCH))) as vision,
        _depth_obstacles(robot, options.obstacles) as depth_obstacles,
        closing(_localiser(robot, world_model, registered)) as localiser,
    ):
        clock = TaskClock(robot.clock, robot.description.pace)
        model = RobotModel(robot.description)
        planning = PlanningSettings(planning_time=options.planning_time)
        controller: MotionController = (
            HolisticController(model)
            if motion is MotionForm.HOLISTIC
            else PlanningController(model, planning=planning)
        )
        moving = tuple(world_model.obstacles(state.stamp))
        controller.prepare(Surroundings(fixtures=world_model.fixtures, moving=moving))
        yield Setup(
            robot=injected,
            recorded=robot,
            clock=clock,
            truth=backend.truth,
            world=backend.world,
            map=str(options.map or backend.map or ""),
            controller=controller,
            gate=Gate(robot, robot.description, controller.settings.period),
            vision=vision,
            context=Context(
                robot=robot,
                model=controller.model,
                clock=clock,
                vision=vision,
                state=state,
                localisation=localiser,
                depth_obstacles=depth_obstacles,
                fixtures=world_model.fixtures,
                obstacles=world_model.obstacles,
                began_at=_time_of_day(options, backend, robot.clock.now()),
                follows_goals=motion is MotionForm.HOLISTIC,
            ),
            problems=problems,
        )


def _time_of_day(options: RunOptions, backend: Backend, elapsed: float) -> float:
    """When the session began, `elapsed` [s] ago; a simulated run is the same at any time."""
    if options.time_of_day is not None:
        return options.time_of_day
    if backend.truth is not None:
        return _NOON
    now = datetime.fromtimestamp(epoch())
    return 3600.0 * now.hour + 60.0 * now.minute + now.second - elapsed


def _localiser(
    robot: RecordedRobot, world_model: WorldModel, registered: Sequence[str]
) -> Localiser:
    """What estimates where the map is."""
    executor = Worker(robot.clock, _REGISTRATION)
    surfaces = map_surfaces(world_model.fixtures)
    return Localiser(surfaces=surfaces, sensors=registered, executor=executor)


@contextmanager
def _depth_obstacles(
    robot: RecordedRobot, obstacles: ObstacleSource
) -> Iterator[DepthObstacles | None]:
    """Obstacles from the depth camera; None for the map."""
    if obstacles is ObstacleSource.MAP:
        yield None
        return
    executor = Worker(robot.clock, _DEPTH_OBSTACLES)
    with closing(DepthObstacles(robot.description, executor)) as depth_obstacles:
        yield depth_obstacles


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
