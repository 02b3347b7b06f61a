"""Setup of a session: connects the robot, and makes controller, gate, vision and context."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from app.choices import MotionForm, ObstacleSource, VisionForm
from app.core.decisions import Decisions
from app.core.measurements import Measurements
from app.core.outcome import Outcome
from app.core.session import Session, Tick
from app.core.world_model import WorldModel, load_world_model
from behaviours import (
    SENSORS,
    Context,
    DepthObstacles,
    Localiser,
    Vision,
    VisionBeside,
    VisionInStep,
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
    InlineExecutor,
    RecordedRobot,
    Robot,
    RobotState,
    TaskClock,
    Truth,
    WorldOptions,
    one_thread,
    open_backend,
)
from perception import GraspDetector


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What a session works with; the robot is connected."""

    robot: FaultInjection
    recorded: RecordedRobot  # the same robot, as the loop sees it
    clock: TaskClock
    truth: Truth | None  # state of the simulated world; None on hardware
    world: str  # what simulates the robot
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
    robot: str,
    world: str,
    options: WorldOptions,
    detector: GraspDetector,
    form: VisionForm,
    *,
    site: Path | None = None,
    **more: Any,
) -> Iterator[Setup]:
    """Connect a robot by name in a world, see `set_up`; `site` replaces the world's own map.

    Raises:
        PlanningError: motions are to be planned, and the planner is not installed.
        UserError: there is no such robot, world or scene, or its file has a mistake.
        HardwareError: the robot cannot be connected.
    """
    backend = open_backend(robot, world, options)
    around = load_world_model(backend.truth, site or backend.map)
    with set_up(backend, detector, form, seed=options.seed, world_model=around, **more) as setup:
        yield setup


@contextmanager
def set_up(
    backend: Backend,
    detector: GraspDetector,
    form: VisionForm,
    *,
    beneath: Callable[[Robot], Robot] = lambda robot: robot,
    seed: int = 0,
    world_model: WorldModel | None = None,
    obstacles: ObstacleSource = ObstacleSource.MAP,
    motion: MotionForm = MotionForm.HOLISTIC,
    planning_time: float = PlanningSettings.planning_time,
    registered: Sequence[str] = SENSORS,
) -> Iterator[Setup]:
    """Connect a robot and set up a session; close everything at the end of the context.

    `beneath` wraps the robot below the fault injection, of which `seed` is the seed; without a
    `world_model` it is that of the simulated world;
    `registered` are the sensors that are matched to the map.

    Raises:
        PlanningError: motions are to be planned, and the planner is not installed.
        HardwareError: the robot cannot be connected.
    """
    injected = FaultInjection(beneath(backend.robot), backend.truth, seed)
    robot = RecordedRobot(injected, backend.clock)
    problems: list[str] = []
    if obstacles is ObstacleSource.CAMERA:
        world_model = WorldModel()
    elif world_model is None:
        world_model = load_world_model(backend.truth)
    make_vision = VisionInStep if form is VisionForm.STEP else VisionBeside
    with (
        _connected(robot, problems) as state,
        closing(make_vision(robot.camera, detector)) as vision,
        _depth_obstacles(robot, form, obstacles) as depth_obstacles,
        closing(_localiser(world_model, form, registered)) as localiser,
    ):
        clock = TaskClock(robot.clock, robot.description.pace)
        model = RobotModel(robot.description)
        controller: MotionController = (
            HolisticController(model)
            if motion is MotionForm.HOLISTIC
            else PlanningController(model, planning=PlanningSettings(planning_time=planning_time))
        )
        moving = tuple(world_model.obstacles(state.stamp))
        controller.prepare(Surroundings(fixtures=world_model.fixtures, moving=moving))
        yield Setup(
            robot=injected,
            recorded=robot,
            clock=clock,
            truth=backend.truth,
            world=backend.world,
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
                follows_goals=motion is MotionForm.HOLISTIC,
            ),
            problems=problems,
        )


def _localiser(world_model: WorldModel, form: VisionForm, registered: Sequence[str]) -> Localiser:
    """What estimates where the map is, within the tick or beside it."""
    executor = InlineExecutor() if form is VisionForm.STEP else one_thread()
    surfaces = map_surfaces(world_model.fixtures)
    return Localiser(surfaces=surfaces, sensors=registered, executor=executor)


@contextmanager
def _depth_obstacles(
    robot: Robot, form: VisionForm, obstacles: ObstacleSource
) -> Iterator[DepthObstacles | None]:
    """Obstacles from the depth camera, computed within the tick or beside it; None for the map."""
    if obstacles is ObstacleSource.MAP:
        yield None
        return
    executor = InlineExecutor() if form is VisionForm.STEP else one_thread()
    with closing(DepthObstacles(robot.description, executor)) as depth_obstacles:
        yield depth_obstacles


@contextmanager
def _connected(robot: Robot, problems: list[str]) -> Iterator[RobotState]:
    """Connect a robot and yield its first reading; errors of closing go to `problems`.

    Raises:
        HardwareError: it cannot be connected or read.
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
