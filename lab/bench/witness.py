"""Judge of the true motion of a robot, beneath the injected faults."""

from collections.abc import Callable

import numpy as np

from config.arrays import Array
from controller import Command
from hw import Robot, RobotState, RobotWrapper

AT_REST = 0.01  # a slower robot is at rest [m/s or rad/s]

_PERIOD = 0.01  # of control [s]
_GAP = 1.5 * _PERIOD  # after this time without a command it may have begun to stop by itself [s]
_ROUNDING = 1.001


class Witness(RobotWrapper):
    """A robot that checks the true readings and the commands against the limits."""

    def __init__(self, robot: Robot, seen: Callable[[], None] = lambda: None) -> None:
        super().__init__(robot)
        self._seen = seen
        self._limits = robot.description.limits
        self.violations = 0
        """Readings beyond a limit of position or velocity, and commands that change a velocity too
        fast. Braking may use the emergency deceleration, and an unused change may be saved up for
        one period."""
        self.state: RobotState | None = None  # the last true reading
        self.stopped = False  # whether the last command was to stop
        self._now = -np.inf
        self._sent = self._before = Command.stop(len(robot.description.arm.joints))

    @property
    def speed(self) -> float:
        """The largest velocity of the last true reading [m/s or rad/s]."""
        if self.state is None:
            return 0.0
        return float(max(np.abs(self.state.qd).max(), np.abs(self.state.base_twist).max()))

    def read(self) -> RobotState:
        """The true reading, checked against the limits."""
        state = self.state = self._robot.read()
        limits = self._limits
        outside = (state.q > limits.q_max + 1e-6) | (state.q < limits.q_min - 1e-6)
        self.violations += bool(outside.any())
        self.violations += _exceeds(state.qd, limits.qd) or _exceeds(
            state.base_twist, limits.base_speed(state.base_twist)
        )
        self._seen()
        return state

    def send(self, command: Command) -> Command:
        """Pass a command on, checked against the one before."""
        self.stopped = False
        state = self._robot.read()
        gap = 0.0
        if state.stamp > self._now:
            gap, self._now, self._before = state.stamp - self._now, state.stamp, self._sent
        dt = min(gap, _GAP) + _PERIOD
        measured = Command(base_twist=state.base_twist, qd=state.qd)
        starts = (self._before, measured) if gap > _GAP else (self._before,)
        self.violations += not any(self._follows(one, command, dt) for one in starts)
        self._sent = self._robot.send(command)
        return self._sent

    def stop(self) -> None:
        """Stop the robot."""
        self.stopped = True
        super().stop()

    def _follows(self, before: Command, command: Command, dt: float) -> bool:
        """Whether a command may follow another within a time [s]."""
        limits, old, new = self._limits, before.base_twist, command.base_twist
        return command.is_finite() and not (
            _changes(old, new, limits.base_acceleration, limits.base_emergency, dt)
            or _changes(before.qd, command.qd, limits.qdd, limits.qdd, dt)
        )


def _changes(before: Array, after: Array, faster: Array, slower: Array, dt: float) -> bool:
    """Whether a velocity changes by more than allowed within a time [s]."""
    brakes = (np.abs(after) < np.abs(before)) & (after * before >= 0.0)
    return _exceeds(after - before, np.where(brakes, slower, faster) * dt)


def _exceeds(values: Array, limits: Array) -> bool:
    return bool((np.abs(values) > limits * _ROUNDING + 1e-6).any())
