"""The robot that a run is for, in its scene, with everything that drives it."""

from __future__ import annotations

from dataclasses import dataclass

from behaviours import Context, Vision
from controller import HolisticController, RobotModel, robot_model
from hw import SimClock
from hw.fault_injection import FaultyRobot
from hw.gate import Gate
from hw.sim import World, load_scene
from hw.sim.robot import SimRobot
from hw.task_clock import TaskClock
from perception import GraspDetector


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What a session works with."""

    world: World
    clock: TaskClock
    robot: FaultyRobot
    controller: HolisticController
    gate: Gate
    vision: Vision
    context: Context

    @property
    def model(self) -> RobotModel:
        """The robot's kinematics; the loop's alone."""
        return self.controller.model


def simulated_setup(
    model: str, *, scene: str, seed: int, paced: bool, detector: GraspDetector
) -> Setup:
    """A simulated robot in a simulated scene.

    Args:
        model: which robot, as `robot_model` knows it.
        scene: a shipped scene or a scene file.
        seed: of the objects and of the camera's noise.
        paced: in real time instead of as fast as it goes.
        detector: finds grasps in what the camera sees.

    Raises:
        SceneError: there is no such scene, or its file has a mistake.
    """
    world = load_scene(scene, seed)
    clock = TaskClock(SimClock(pace=1.0 if paced else None))
    robot = FaultyRobot(SimRobot(robot_model(model), world, clock.session, seed=seed))
    controller = HolisticController(robot_model(model))
    vision = Vision(robot, detector)
    return Setup(
        world=world,
        clock=clock,
        robot=robot,
        controller=controller,
        gate=Gate(robot, controller.model.limits, controller.settings.period),
        vision=vision,
        context=Context(
            robot=robot, model=controller.model, clock=clock, vision=vision, state=robot.read()
        ),
    )
