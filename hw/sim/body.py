"""Base class of simulated robots: they follow the newest command for one period."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from threading import RLock

import numpy as np
from pinocchio import SE3

from controller import Command, RobotModel
from hw.clock import Clock
from hw.sim.localisation_errors import LocalisationProcess
from hw.sim.sim_object import Visible
from hw.sim.sim_robot_shapes import Hand
from hw.sim.sim_world import World
from hw.truth import Touch, Truth
from robots import Array, RobotDescription


@dataclass(frozen=True, kw_only=True)
class Dynamics:
    """Parameters of a simulated robot beyond its description."""

    period: float = 0.01  # of a command [s]; without a new one the robot stops
    battery_life: float = 4.0 * 3600.0  # time in which a full battery runs down [s]


_SAME_TOUCH = 1.0  # a contact that comes back within this time is not new [s]
_GIVEN = SE3(np.eye(3), np.array([0.0, 0.0, 0.02]))  # what a person gives, in the hand


class Reflex:
    """Stops a part of the robot on a contact."""

    def __init__(self) -> None:
        self.reason: str | None = None  # the contact, for people; None while the part may move
        self.towards: Array = np.zeros(3)  # unit vector to the contact in the world; 0 if unknown

    def trip(self, reason: str, towards: Array | None = None) -> None:
        """Stop the part on a contact in a direction (3,) in the world."""
        self.reason = reason
        self.towards = np.zeros(3) if towards is None else towards

    def clear(self) -> None:
        """Let the part move again."""
        self.reason, self.towards = None, np.zeros(3)


class SimBody(ABC):
    """The state of a simulated robot, advanced to the clock; locked, as its parts share it."""

    reflex: Reflex  # of the arm, its hand and the held object
    bumper: Reflex  # Of the base

    def __init__(
        self,
        description: RobotDescription,
        world: World,
        clock: Clock,
        dynamics: Dynamics,
        wheels: LocalisationProcess,
    ) -> None:
        self.description = description
        self.wheels = wheels
        self.world = world
        self.truth: Truth | None = world
        self.dynamics = dynamics
        self._model = RobotModel(description)
        self._clock = clock
        self._lock = RLock()
        self.now = clock.now()
        self.wTb = SE3.Identity()
        self.base_twist: Array = np.zeros(3)  # as its wheels tell: they slip
        self.q = description.arm.ready.copy()
        self.qd: Array = np.zeros(len(self.q))
        self.width = description.gripper.opening
        self.fingers_move = False
        self._stop = Command.stop(len(self.q))
        self._command = self._stop
        self._valid_until = 0.0
        self._touched: dict[tuple[str, str], float] = {}
        self._begin()

    @abstractmethod
    def _begin(self) -> None:
        """Complete the state, once the rest of it is made."""

    @property
    def wTe(self) -> SE3:
        """End effector in the world."""
        return self._model.end_effector(self.wTb, self.q)

    @property
    def hand(self) -> Hand:
        """The hand in the world."""
        return Hand(self.description.gripper, self.wTe)

    def shapes(self) -> list[Visible]:
        """All visual shapes, the hand included, in the world."""
        return [*self.world.shapes(), *self.hand.shapes(self.width)]

    def advance(self) -> None:
        """Integrate up to the clock's time, a period at a time."""
        with self._lock:
            now = self._clock.now()
            while self.now < now - 1e-9:
                dt = min(self.dynamics.period, now - self.now)
                if (given := self.world.given) is not None:
                    given.pose, given.motion = self.wTe * _GIVEN, None
                is_valid = self.now < self._valid_until - 1e-9
                self._integrate(self._command if is_valid else self._stop, dt)
                self.now += dt
                if self.world.held is not None:
                    self.world.given = None
            if self.now != now:  # by rounding: what is told of now must be where it is now
                self._set_time(now)
                self.now = now
            self.world.base = self.wTb

    def follow(self, *, base_twist: Array | None = None, qd: Array | None = None) -> None:
        """Follow a twist of the base, or joint velocities, for one period from now on."""
        with self._lock:
            self.advance()
            stale = self.now >= self._valid_until - 1e-9
            before = self._stop if stale else self._command
            self._command = Command(
                base_twist=before.base_twist if base_twist is None else base_twist,
                qd=before.qd if qd is None else qd,
            )
            self._valid_until = self.now + self.dynamics.period

    def stop(self) -> None:
        """Drop the command: the robot comes to rest with its lag."""
        with self._lock:
            self._command = self._stop

    def grip(self, width: float, force: float) -> None:
        """Move the fingers to a width [m] with at most a force of each [N]."""
        with self._lock:
            self.advance()
            self._grip(width, force)

    @abstractmethod
    def _grip(self, width: float, force: float) -> None: ...

    @abstractmethod
    def _integrate(self, command: Command, dt: float) -> None:
        """Apply a command for a time [s] from now on, to the robot and its world."""

    @abstractmethod
    def _set_time(self, now: float) -> None:
        """Bring moving obstacles and objects to a time [s]."""

    def _note_touch(self, part: str, thing: str, text: str, now: float) -> None:
        """Record a collision, unless it is the same contact as just before."""
        if now - self._touched.get((part, thing), -np.inf) > _SAME_TOUCH:
            self.world.touches.append(Touch(stamp=now, part=part, thing=thing, text=text))
        self._touched[part, thing] = now
