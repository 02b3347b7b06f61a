"""The simulated robot in its world: kinematics with lag, and what happens when it hits something.

A step that makes a contact is taken back and trips a reflex: the bumper for the base, that of the
arm for the arm, its hand and what it holds. What it belongs to stands still at once; the other one
goes on until somebody who sees the fault stops it, or until furniture holds the arm that it pushes.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import Command, RobotModel
from hw.clock import Clock
from hw.sim.collisions import Collisions, Contact
from hw.sim.hand import Hand
from hw.sim.members import BASE, HAND_TOLERANCE, Configuration
from hw.sim.reflex import Reflex
from hw.sim.sim_object import SimObject
from hw.sim.surface import Visible
from hw.sim.world import World
from hw.truth import Touch
from robots import RobotDescription


@dataclass(frozen=True, kw_only=True)
class Dynamics:
    """How the simulated robot answers to commands, beyond what its description says."""

    period: float = 0.01
    """A command holds for one period [s]; without a new one the robot stops."""
    slip_distance: float = 0.005
    """How far the hand moves until fingers that press without holding slip off [m]."""
    battery_life: float = 4.0 * 3600.0
    """Time in which a full battery runs down, whatever the robot does [s]."""


_SAME_TOUCH = 1.0
"""A contact that comes back within this time is no new one [s]."""


class SimBody:
    """Integrates what was commanded up to the clock's time; the parts of the robot share it.

    Args:
        description: which robot.
        world: what is around it.
        clock: simulated time.
        dynamics: how it answers.
    """

    def __init__(
        self, description: RobotDescription, world: World, clock: Clock, dynamics: Dynamics
    ) -> None:
        self.description = description
        self.world = world
        self.dynamics = dynamics
        self._model = RobotModel(description)
        self._clock = clock
        self.now = clock.now()
        self.wTb = SE3.Identity()
        self.base_twist = np.zeros(3)
        self.q = description.arm.ready.copy()
        self.qd = np.zeros(7)
        self.width = description.gripper.opening
        self.fingers_move = False
        self.reflex = Reflex()
        """Of the arm, its hand and what it holds."""
        self.bumper = Reflex()
        """Of the base."""
        self._command = Command.stop()
        self._valid_until = 0.0
        self._width_goal = self.width
        self._pressing_from: SE3 | None = None
        self._wanted_width = self.width
        self._holds = False
        self._slipping = False
        self._collisions = Collisions(self._model, world)
        self._touched: dict[tuple[str, str], float] = {}

    @property
    def wTe(self) -> SE3:
        """End effector in the world."""
        return self._model.wTe(self.wTb, self.q)

    @property
    def hand(self) -> Hand:
        """The hand in the world."""
        return Hand(self.description.gripper, self.wTe)

    def shapes(self) -> list[Visible]:
        """All that its camera can see, the hand included, in the world."""
        return [*self.world.shapes(), *self.hand.shapes(self.width)]

    def advance(self) -> None:
        """Integrate up to the clock's time, a period at a time."""
        now = self._clock.now()
        while self.now < now - 1e-9:
            dt = min(self.dynamics.period, now - self.now)
            command = self._command if self.now < self._valid_until - 1e-9 else Command.stop()
            self.world.move_to(self.now + dt)
            self._integrate(command, dt)
            self.now += dt
        if self.now != now:  # by rounding: what is told of now must be where it is now
            self.world.move_to(now)
            self.now = now

    def follow(self, *, base_twist: np.ndarray | None = None, qd: np.ndarray | None = None) -> None:
        """Follow a twist of the base, or velocities of the joints, for one period from now on."""
        self.advance()
        stale = self.now >= self._valid_until - 1e-9
        before = Command.stop() if stale else self._command
        self._command = Command(
            base_twist=before.base_twist if base_twist is None else base_twist,
            qd=before.qd if qd is None else qd,
        )
        self._valid_until = self.now + self.dynamics.period

    def stop(self) -> None:
        """Forget the command: the robot comes to rest with its lag."""
        self._command = Command.stop()

    def grip(self, width: float, force: float) -> None:
        """Move the fingers to a width [m]; closing stops at what the contacts decide.

        The contacts are decided on the pose of the hand when closing starts. Fingers that press on
        an object without holding it close the rest of the way when the hand moves off.
        """
        self.advance()
        if width > self.width:
            self.world.open_fingers()
            self._width_goal = min(width, self.description.gripper.opening)
            self._pressing_from, self._holds = None, False
        else:
            hand = self.hand
            outcome = self.world.close_fingers(hand, self.width, force, width)
            self._width_goal, self._wanted_width = outcome.width, width
            self._holds = outcome.holding is not None
            if not self._holds:
                self._pressing_from = hand.wTe
        self._slipping = False
        self.fingers_move = self.width != self._width_goal

    def _integrate(self, command: Command, dt: float) -> None:
        """First-order lag on every axis, then exact motion along the arc that it gives."""
        before, q_before = self.wTb, self.q
        base_lag, arm_lag = self.description.base.lag, self.description.arm.lag
        self.base_twist = self.base_twist + (1.0 - exp(-dt / base_lag)) * (
            command.base_twist - self.base_twist
        )
        if self.bumper.tripped_by:
            self.base_twist = np.zeros(3)
        vx, vy, w = self.base_twist * dt
        self.wTb = self.wTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        if self.reflex.tripped_by:
            self.qd = np.zeros(7)
        else:
            self.qd = self.qd + (1.0 - exp(-dt / arm_lag)) * (command.qd - self.qd)
            self.q = self.q + self.qd * dt
        self._move_fingers(self.description.gripper.speed * dt)
        self._slip()
        self._collide(before, q_before, self.now + dt)
        self._carry()

    def _collide(self, wTb: SE3, q: np.ndarray, now: float) -> None:
        """Take back what has made a contact since the base was at wTb and the arm at q (7,)."""
        base, arm = self._contacts(now)
        if self.bumper.feels(base):
            self.bumper.trip(base)
            self.wTb, self.base_twist = wTb, np.zeros(3)
            base, arm = self._contacts(now)
        if self.reflex.feels(arm):
            self.reflex.trip(arm)
            self.q, self.qd = q, np.zeros(7)
            base, arm = self._contacts(now)
        if self.reflex.feels(arm):  # the base has pushed the arm there
            self._push_away(arm)
            base, arm = self._contacts(now)
            if self.reflex.feels(arm):
                self.wTb, self.base_twist = wTb, np.zeros(3)
                base, arm = self._contacts(now)
        self.bumper.stay(base)
        self.reflex.stay(arm)

    def _move_fingers(self, step: float) -> None:
        """A step towards the width that is wanted; slipping fingers slide along the object."""
        if self._holds and self.world.held is None:  # somebody took it out of the hand
            self._holds, self._width_goal = False, self._wanted_width
        width = self.width + float(np.clip(self._width_goal - self.width, -step, step))
        # They lie against it, and press in no deeper: a hit is what is deeper than a tolerance.
        pressed = max(0.0, width - 2.0 * HAND_TOLERANCE)
        if self._slipping and self.world.collision(self.hand, pressed):
            width = self.width
        self.fingers_move = width != self.width
        self.width = width

    def _slip(self) -> None:
        """Slip off what is pressed on without being held, when the hand moves off."""
        if self._pressing_from is not None:
            moved = np.linalg.norm(self.wTe.translation - self._pressing_from.translation)
            if moved > self.dynamics.slip_distance:
                self._slipping, self._pressing_from = True, None
                self._width_goal = self._wanted_width

    def _carry(self) -> None:
        """Take along what is held."""
        if self.world.held is not None:
            self.world.carry(self.wTe)
            self.world.settle()

    def _contacts(self, now: float) -> tuple[list[Contact], list[Contact]]:
        """What the base presses into and what the arm does, noted down where it is new."""
        here = Configuration(wTb=self.wTb, q=self.q, width=self.width)
        contacts = self._collisions.find(here)
        for one in contacts:
            if one.excess <= 0.0:
                continue
            if now - self._touched.get((one.part, one.thing), -np.inf) > _SAME_TOUCH:
                touch = Touch(stamp=now, part=one.part, thing=one.thing, text=one.text)
                self.world.touches.append(touch)
            self._touched[one.part, one.thing] = now
        return (
            [one for one in contacts if one.part == BASE],
            [one for one in contacts if one.part != BASE],
        )

    def _push_away(self, contacts: list[Contact]) -> None:
        """Loose objects give way to the arm."""
        for one in contacts:
            if one.excess > 0.0 and isinstance(one.owner, SimObject):
                self.world.push(one.owner, one.towards, one.depth)
