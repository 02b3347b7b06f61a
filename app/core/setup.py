"""Everything that drives a robot through a task: what a session works with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from app.choices import MotionForm, ObstacleSource, VisionForm
from app.core.known import Known, known_of
from behaviours import Context, DepthObstacles, Vision, VisionBeside, VisionInStep
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
    Camera,
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

_VISION: dict[VisionForm, Callable[[Camera, GraspDetector], Vision]] = {
    VisionForm.STEP: VisionInStep,
    VisionForm.BESIDE: VisionBeside,
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What a session works with."""

    robot: FaultInjection
    """Connected."""
    recorded: RecordedRobot
    """The same robot, as the loop sees it."""
    clock: TaskClock
    truth: Truth | None
    """What is known of the world; None on hardware."""
    world: str
    """What moves the robot."""
    controller: MotionController
    gate: Gate
    vision: Vision
    context: Context
    problems: list[str]
    """What goes wrong when all is closed."""

    @property
    def model(self) -> RobotModel:
        """The robot's kinematics; the loop's alone."""
        return self.controller.model


@contextmanager
def open_setup(
    robot: str,
    world: str,
    options: WorldOptions,
    detector: GraspDetector,
    form: VisionForm,
    beneath: Callable[[Robot], Robot] = lambda robot: robot,
    obstacles: ObstacleSource = ObstacleSource.MAP,
    site: Path | None = None,
    motion: MotionForm = MotionForm.HOLISTIC,
    planning_time: float = PlanningSettings.planning_time,
) -> Iterator[Setup]:
    """Connect a robot and put together what a session works with; closes it in the end.

    Args:
        robot: name of a shipped robot, or a robot file.
        world: what moves it.
        options: of the world.
        detector: finds grasps in what the camera sees.
        form: how that is done.
        beneath: what to put between the robot and the faults that are injected into it.
        obstacles: what tells what stands around the robot.
        site: the map of what stands around; None for the world's own.
        motion: how the robot gets to its goals.
        planning_time: the robot stands for this long whenever it plans [s].

    Raises:
        PlanningError: motions are to be planned, and what does it is not installed.
        UserError: there is no such robot, world or scene, or its file has a mistake.
        HardwareError: the robot cannot be connected.
    """
    backend = open_backend(robot, world, options)
    known = known_of(backend.truth, site or backend.map)
    with set_up(
        backend,
        detector,
        form,
        beneath=beneath,
        seed=options.seed,
        known=known,
        obstacles=obstacles,
        motion=motion,
        planning_time=planning_time,
    ) as setup:
        yield setup


@contextmanager
def set_up(
    backend: Backend,
    detector: GraspDetector,
    form: VisionForm,
    *,
    beneath: Callable[[Robot], Robot] = lambda robot: robot,
    seed: int = 0,
    known: Known | None = None,
    obstacles: ObstacleSource = ObstacleSource.MAP,
    motion: MotionForm = MotionForm.HOLISTIC,
    planning_time: float = PlanningSettings.planning_time,
) -> Iterator[Setup]:
    """Connect a robot and put together what a session works with; closes it in the end.

    Args:
        backend: the robot, its clock and its world.
        detector: finds grasps in what the camera sees.
        form: how that is done.
        beneath: what to put between the robot and the faults that are injected into it.
        seed: of the faults.
        known: what the robot is told of its surroundings; None for what its world knows.
        obstacles: what tells what stands around the robot.
        motion: how the robot gets to its goals.
        planning_time: the robot stands for this long whenever it plans [s].

    Raises:
        PlanningError: motions are to be planned, and what does it is not installed.
        HardwareError: the robot cannot be connected.
    """
    injected = FaultInjection(beneath(backend.robot), backend.truth, seed)
    robot = RecordedRobot(injected, backend.clock)
    problems: list[str] = []
    if obstacles is ObstacleSource.CAMERA:
        known = Known()
    elif known is None:
        known = known_of(backend.truth)
    with (
        _connected(robot, problems) as state,
        closing(_VISION[form](robot.camera, detector)) as vision,
        _seen(robot, form, obstacles) as seen,
    ):
        clock = TaskClock(robot.clock, robot.description.pace)
        model = RobotModel(robot.description)
        controller: MotionController = (
            HolisticController(model)
            if motion is MotionForm.HOLISTIC
            else PlanningController(model, planning=PlanningSettings(planning_time=planning_time))
        )
        moving = tuple(known.obstacles(state.stamp))
        controller.prepare(Surroundings(fixtures=known.fixtures, moving=moving))
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
                depth_obstacles=seen,
                fixtures=known.fixtures,
                obstacles=known.obstacles,
                follows_goals=motion is MotionForm.HOLISTIC,
            ),
            problems=problems,
        )


@contextmanager
def _seen(
    robot: Robot, form: VisionForm, obstacles: ObstacleSource
) -> Iterator[DepthObstacles | None]:
    """What looks for obstacles, in step with the tick or beside the loop; None if nothing does."""
    if obstacles is ObstacleSource.MAP:
        yield None
        return
    executor = InlineExecutor() if form is VisionForm.STEP else one_thread()
    with closing(DepthObstacles(robot.description, executor)) as seen:
        yield seen


@contextmanager
def _connected(robot: Robot, problems: list[str]) -> Iterator[RobotState]:
    """A robot from its first reading to its end; what goes wrong in the end is noted, not raised.

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
