"""The physical robot: motors move it, contacts carry, drop, topple and stop things and it.

Nothing is decided here about what holds and what is hit. The body tells the motors what they are to
do, and reads off where everything is; what is held is what both fingers press on.
"""

from __future__ import annotations

from math import cos, exp, sin

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import Command
from hw.clock import Clock
from hw.sim.body import Dynamics, SimBody
from hw.sim.physics.engine import Engine
from hw.sim.physics.mjcf import TIMESTEP
from hw.sim.physics.reflex import ForceReflex
from hw.sim.physics.simulation import Press, between_fingers
from hw.sim.robot_shapes import BASE, FINGERS, HELD
from hw.sim.sim_object import SimObject
from hw.sim.world import World
from robots import Array, RobotDescription

_SETTLING = 1.0  # Before a run begins everything comes to rest for this long [s]
_REFLEX_FORCE, _BUMPER_FORCE = 30.0, 30.0  # On the tool and on the base [N]
_FILTER = 0.02  # Time constant with which forces are estimated [s]
_TOUCH = 1.0  # Smallest force that counts as a contact [N]
_SETTING_DOWN = 20.0  # With more than that the held object is not set down, but hits something [N]
_HOLDING_FORCE = 20.0  # Of the fingers until they are told another one [N]
_AT_WIDTH, _STILL_SPEED, _STILL_TIME = 5e-4, 0.004, 0.1
"""Fingers have come to rest at their width [m], or after a time [s] below a speed [m/s]."""


class PhysicalBody(SimBody):
    """A robot of rigid bodies with motors, among rigid bodies."""

    reflex: ForceReflex
    bumper: ForceReflex

    def __init__(
        self, description: RobotDescription, world: World, clock: Clock, dynamics: Dynamics
    ) -> None:
        super().__init__(description, world, clock, dynamics)
        self.reflex = ForceReflex(_REFLEX_FORCE)
        self.bumper = ForceReflex(_BUMPER_FORCE)
        self.engine = Engine(description, world)
        self._poses = [obj.pose for obj in world.objects]
        """As they were told last: who replaces the pose of an object moves it."""
        self._twist = np.zeros(3)
        self._load = np.zeros(7)
        self._pushed = 0.0
        self._width_goal = self._width_now = self.width
        self._force = _HOLDING_FORCE
        self._still_for = 0.0
        self._opening = True
        for _ in range(round(_SETTLING / TIMESTEP)):
            self.engine.step()
        self._steps = 0
        self._begun = self.now
        self._look()

    def _grip(self, width: float, force: float) -> None:
        self._opening = width > self.width
        self._width_goal = float(np.clip(width, 0.0, self.description.gripper.opening))
        self._width_now, self._force = self.width, force
        self.fingers_move = abs(self._width_goal - self.width) > _AT_WIDTH
        self._still_for = 0.0

    def _integrate(self, command: Command, dt: float) -> None:
        self._put_what_was_moved()
        if self.reflex.reason is None:
            self.engine.turn(command.qd)
        pinched = None
        end = round((self.now + dt - self._begun) / TIMESTEP)
        while self._steps < end:
            self._drive(command.base_twist)
            self._drive_fingers()
            self._move_by_themselves()
            self.engine.step()
            self._steps += 1
            presses = self.engine.presses(self.world.held)
            self._feel(presses)
            self._note(presses)
            pinched = between_fingers(presses) or pinched
        self.world.held = None if self._opening else pinched
        self._set_time(self.now + dt)
        self._look()
        self._rest_fingers(dt)

    @property
    def _time(self) -> float:
        """That the engine has come to [s]."""
        return self._begun + self._steps * TIMESTEP

    def _set_time(self, now: float) -> None:
        for number, walker in enumerate(self.world.walkers):
            walker.move_to(now)
            self.engine.put_walker(number, walker.pose)

    def _put_what_was_moved(self) -> None:
        """Into the engine what somebody has put elsewhere in the world."""
        for number, obj in enumerate(self.world.objects):
            if obj.pose is not self._poses[number]:
                self.engine.put_object(number, obj.pose)
                self._poses[number] = obj.pose

    def _move_by_themselves(self) -> None:
        """Walkers, and objects on their way until they are touched."""
        now = self._time
        self._set_time(now)
        for number, obj in enumerate(self.world.objects):
            if obj.motion is not None:
                here = obj.motion.position(now)
                velocity = (obj.motion.position(now + TIMESTEP) - here) / TIMESTEP
                self.engine.push_object(number, here[:2], velocity[:2])

    def _drive(self, twist: Array) -> None:
        """The base follows a twist (3,) with its lag, and not with its bumper pressed."""
        self._twist += _share(self.description.base.lag) * (twist - self._twist)
        if self.bumper.reason is not None:
            self._twist = np.zeros(3)
        self.engine.drive(self._twist)

    def _drive_fingers(self) -> None:
        """The width that is asked for changes at the gripper's speed."""
        step = self.description.gripper.speed * TIMESTEP
        self._width_now += float(np.clip(self._width_goal - self._width_now, -step, step))
        self.engine.press(self._width_now, self._force)

    def _rest_fingers(self, dt: float) -> None:
        """Whether the fingers still move."""
        self._still_for = self._still_for + dt if self.engine.finger_speed < _STILL_SPEED else 0.0
        if abs(self.width - self._width_goal) < _AT_WIDTH or self._still_for > _STILL_TIME:
            self.fingers_move = False

    def _feel(self, presses: list[Press]) -> None:
        """Estimate the forces, and trip on them."""
        self._load += _share(_FILTER) * (self.engine.load - self._load)
        pushed = sum(press.force for press in presses if press.part == BASE)
        self._pushed += _share(_FILTER) * (pushed - self._pushed)
        if self.bumper.feels(self._pushed):
            hardest = _hardest([press for press in presses if press.part == BASE])
            towards = None if hardest is None else hardest.towards
            self.bumper.trip(_text(hardest, self.world.held), towards)
        force = self.engine.force_at_tool(self._load)
        if self.reflex.feels(force):
            on_arm = [press for press in presses if press.part != BASE]
            told = _text(_hardest(on_arm), self.world.held)
            self.reflex.trip(f"{told} with {force:.0f} N")
            self.engine.relax()

    def _note(self, presses: list[Press]) -> None:
        """Note down what the robot touches; what it touches no longer moves by itself."""
        for press in presses:
            if press.force < (_SETTING_DOWN if press.part == HELD else _TOUCH):
                continue
            if isinstance(press.owner, SimObject):
                press.owner.motion = None
                if press.part == FINGERS:  # that is what they are for
                    continue
            text = _text(press, self.world.held)
            self._note_touch(press.part, press.thing, text, self._time)

    def _look(self) -> None:
        """Read off where everything is."""
        engine = self.engine
        x, y, heading = engine.base.tolist()
        c, s = cos(heading), sin(heading)
        vx, vy, w = engine.base_velocity.tolist()
        self.wTb = SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))
        sideways = -s * vx + c * vy if self._model.n_base == 3 else 0.0  # as odometry tells
        self.base_twist = np.array([c * vx + s * vy, sideways, w])
        self.q, self.qd = engine.q, engine.qd
        opening = self.description.gripper.opening
        self.width = float(np.clip(engine.width, 0.0, opening))
        for number, obj in enumerate(self.world.objects):
            obj.pose = self._poses[number] = engine.object_pose(number)


def _share(lag: float) -> float:
    """Of a step that a first-order lag [s] follows in one `TIMESTEP`."""
    return 1.0 - exp(-TIMESTEP / lag)


def _hardest(presses: list[Press]) -> Press | None:
    return max(presses, key=lambda press: press.force, default=None)


def _text(press: Press | None, held: SimObject | None) -> str:
    """Who hit what, for people."""
    if press is None:
        return "the arm met something"
    if press.part == HELD and held is not None:
        return f"{held.name} in the hand hit {press.thing}"
    who = press.part if press.part.startswith("link") else f"the {press.part}"
    return f"{who} hit {press.thing}"
