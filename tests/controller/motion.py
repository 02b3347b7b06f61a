"""Robots that follow their commands, exactly or late, to run the controller in a loop."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import (
    OPEN_FLOOR,
    Command,
    ControllerSettings,
    HolisticController,
    MotionGoal,
    RobotModel,
    StepReport,
    Surroundings,
    robot_model,
)
from controller.collision.distance_constraints import DistanceConstraints
from controller.collision.proximity import Proximity
from robots import load_robot

READY = load_robot("frankie").arm.ready


def tool_pose(x: float, y: float, z: float, yaw: float = 0.0, tilt: float = 0.0) -> SE3:
    """Hand pointing down, turned by yaw about the world's z and tilted forward."""
    return SE3(pin.rpy.rpyToMatrix(np.pi, tilt, yaw), np.array([x, y, z]))


def proximity(model: RobotModel) -> Proximity:
    """The proximity queries of a controller with default settings."""
    settings = ControllerSettings()
    return Proximity(model, DistanceConstraints(model, settings.period).ranges)


@dataclass
class State:
    mTb: SE3 = field(default_factory=SE3.Identity)
    q: np.ndarray = field(default_factory=READY.copy)


def move(state: State, command: Command, dt: float = 0.01) -> None:
    """What a perfect robot does in one period."""
    vx, vy, w = command.base_twist * dt
    state.mTb = state.mTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
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
    states: list[State]
    reports: list[StepReport] = field(default_factory=list)

    @property
    def arrived(self) -> bool:
        return self.reports[-1].arrived

    @property
    def state(self) -> State:
        return self.states[-1]


def run_to(
    goal: MotionGoal | Callable[[float], MotionGoal] | None,
    *,
    robot: str = "frankie",
    state: State | None = None,
    last: Command | None = None,
    seconds: float = 20.0,
    controller: HolisticController | None = None,
    around: Surroundings | Callable[[float], Surroundings] = OPEN_FLOOR,
    late: bool = False,
    stays: bool = False,
) -> Run:
    """Step the controller until it arrives or the time is over; it keeps every limit.

    Args:
        goal: and `around`: of the whole way, or of a time [s].
        late: the robot follows its commands with its lags.
        stays: the controller is stepped for all of the time.
    """
    controller = controller or HolisticController(robot_model(robot))
    follower = Lagging(controller.model)
    follower.state = state = State(state.mTb, state.q) if state else State()
    run = Run([last or Command.stop(7)], [State(state.mTb, state.q)])
    for step in range(round(seconds / 0.01)):
        now, known = (one(0.01 * step) if callable(one) else one for one in (goal, around))
        command, report = controller.step(state, now, run.commands[-1], known)
        run.commands.append(command)
        run.reports.append(report)
        if report.arrived and not stays:
            break
        if late:
            follower.follow(command)
        else:
            move(state, command)
        run.states.append(State(state.mTb, state.q))
    assert_within_limits(run, controller.model)
    return run


def assert_within_limits(run: Run, model: RobotModel) -> None:
    """No velocity or acceleration limit passed in any sample, nor one of position from inside."""
    velocities = np.array([model.velocities(command) for command in run.commands])
    lower, upper = model.velocity_limits
    assert (velocities >= lower - 1e-12).all()
    assert (velocities <= upper + 1e-12).all()
    accelerations = np.diff(velocities, axis=0) / 0.01
    assert (np.abs(accelerations) <= model.acceleration_limits + 1e-9).all()
    low, high = model.limits.q_min, model.limits.q_max
    q = np.array([state.q for state in run.states])
    inside = (low <= q[0]) & (q[0] <= high)
    assert ((low <= q) & (q <= high))[:, inside].all()
