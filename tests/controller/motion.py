"""Robots that follow their commands, exactly or late, to run the controller in a loop."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import (
    Command,
    ControllerSettings,
    HolisticController,
    MotionGoal,
    RobotModel,
    SelfCollision,
    StepReport,
    robot_model,
)
from controller.collision.distance_constraints import DistanceConstraints
from controller.collision.proximity import Proximity
from controller.model import Lag
from robots import load_robot

READY = load_robot("frankie").arm.ready


def tool_pose(x: float, y: float, z: float, yaw: float = 0.0, tilt: float = 0.0) -> SE3:
    """Hand pointing down, turned by yaw about the world's z and tilted forward."""
    return SE3(pin.rpy.rpyToMatrix(np.pi, tilt, yaw), np.array([x, y, z]))


def reachable_poses(robot: str, count: int, seed: int) -> list[SE3]:
    """Random poses within 4 m that the robot can have somewhere without touching anything."""
    model, rng = robot_model(robot), np.random.default_rng(seed)
    body, poses = SelfCollision(model), []
    while len(poses) < count:
        q = rng.uniform(model.limits.q_min + 0.1, model.limits.q_max - 0.1)
        bTe = model.bTe(q)
        if bTe.translation[2] < 0.05 or body.clearance(q) < 0.0:
            continue
        heading, bearing = rng.uniform(-np.pi, np.pi, size=2)
        radius = 3.6 * np.sqrt(rng.uniform())
        x, y = radius * np.cos(bearing), radius * np.sin(bearing)
        turned = pin.utils.rotate("z", heading) @ bTe.rotation
        poses.append(SE3(turned, np.array([x, y, bTe.translation[2]])))
    return poses


def proximity(model: RobotModel) -> Proximity:
    """The proximity queries of a controller with default settings."""
    settings = ControllerSettings()
    assert settings.collision is not None
    lag = Lag(model, settings.period)
    return Proximity(model, DistanceConstraints(model, settings.collision, lag).ranges)


@dataclass
class State:
    wTb: SE3 = field(default_factory=SE3.Identity)
    q: np.ndarray = field(default_factory=READY.copy)


def move(state: State, command: Command, dt: float = 0.01) -> None:
    """What a perfect robot does in one period."""
    vx, vy, w = command.base_twist * dt
    state.wTb = state.wTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
    state.q = state.q + command.qd * dt


class Lagging:
    """Follows its commands as the real robot does: late."""

    def __init__(self, model: RobotModel) -> None:
        self.state = State()
        lags = np.array([model.description.base.lag, model.description.arm.lag])
        self._share = 1.0 - np.exp(-0.01 / lags)
        self._base, self._arm = np.zeros(3), np.zeros(7)

    def follow(self, command: Command) -> None:
        self._base += self._share[0] * (command.base_twist - self._base)
        self._arm += self._share[1] * (command.qd - self._arm)
        move(self.state, Command(base_twist=self._base, qd=self._arm))


@dataclass
class Run:
    """Everything that happened on the way to a goal."""

    commands: list[Command]
    postures: list[np.ndarray]
    reports: list[StepReport]
    state: State

    @property
    def arrived(self) -> bool:
        return self.reports[-1].arrived


def run_to(
    goal: MotionGoal | None,
    *,
    robot: str = "frankie",
    state: State | None = None,
    last: Command | None = None,
    seconds: float = 20.0,
    controller: HolisticController | None = None,
) -> Run:
    """Step the controller until it arrives or the time is over."""
    controller = controller or HolisticController(robot_model(robot))
    dt = controller.settings.period
    state = state or State()
    run = Run([last or Command.stop(7)], [state.q.copy()], [], state)
    for _ in range(round(seconds / dt)):
        command, report = controller.step(state, goal, run.commands[-1])
        run.commands.append(command)
        run.reports.append(report)
        if report.arrived:
            break
        move(state, command, dt)
        run.postures.append(state.q.copy())
    return run


def assert_within_limits(run: Run, robot: str | RobotModel) -> None:
    """No velocity, acceleration or position limit passed in any sample."""
    model = robot_model(robot) if isinstance(robot, str) else robot
    velocities = np.array([model.velocities(command) for command in run.commands])
    lower, upper = model.velocity_limits
    assert (velocities >= lower - 1e-12).all()
    assert (velocities <= upper + 1e-12).all()
    accelerations = np.diff(velocities, axis=0) / 0.01
    assert (np.abs(accelerations) <= model.acceleration_limits + 1e-9).all()
    postures = np.array(run.postures)
    assert (postures >= model.limits.q_min).all()
    assert (postures <= model.limits.q_max).all()
