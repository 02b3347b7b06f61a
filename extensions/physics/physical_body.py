"""Physical robot: motors move it, and contacts, not rules, decide what is held and hit."""

from __future__ import annotations

from math import exp

import numpy as np

from config.arrays import Array
from config.planar import Pose2D, rotate
from controller import Command, se3_of
from extensions.physics.mjcf import TIMESTEP
from extensions.physics.simulation import Press, RobotSimulation, between_fingers
from hw.sim import BASE, FINGERS, HELD, Reflex, SimBody, SimObject

_MARGIN = 15.0  # by which a forgiven force may grow [N]
_SETTLING = 1.0  # time for all bodies to come to rest before a run [s]
_REFLEX_FORCE, _BUMPER_FORCE = 30.0, 30.0  # On the tool and on the base [N]
_FILTER = 0.02  # time constant of the force estimate [s]
_TOUCH = 1.0  # Smallest force that counts as a contact [N]
_SETTING_DOWN = 20.0  # a larger force on the held object is a collision [N]
_HOLDING_FORCE = 20.0  # initial force of the fingers [N]
_AT_WIDTH, _STILL_SPEED, _STILL_TIME = 5e-4, 0.004, 0.1  # [m], or after [s] below [m/s]


class PhysicalBody(SimBody):
    """A robot of rigid bodies with motors, among rigid bodies."""

    reflex: ForceReflex
    bumper: ForceReflex

    def _begin(self) -> None:
        self.reflex = ForceReflex(_REFLEX_FORCE)
        self.bumper = ForceReflex(_BUMPER_FORCE)
        self.engine = RobotSimulation(self.description, self.world)
        self._poses = [obj.pose for obj in self.world.objects]  # a replaced one moves it
        self._twist = np.zeros(3)
        self._load = np.zeros(len(self.q))
        self._push_force = 0.0
        self._width_goal = self._width_now = self.width
        self._force = _HOLDING_FORCE
        self._still_for = 0.0
        self._opening = True
        for _ in range(round(_SETTLING / TIMESTEP)):
            self.engine.step()
        self._steps = 0
        self._begun = self.now
        self._read_engine()

    def _grip(self, width: float, force: float) -> None:
        self._opening = width > self.width
        self._width_goal = float(np.clip(width, 0.0, self.description.gripper.opening))
        self._width_now, self._force = self.width, force
        self.fingers_move = abs(self._width_goal - self.width) > _AT_WIDTH
        self._still_for = 0.0

    def _integrate(self, command: Command, dt: float) -> None:
        self._put_moved_objects()
        if self.reflex.reason is None:
            self.engine.turn(command.qd)
        pinched = None
        end = round((self.now + dt - self._begun) / TIMESTEP)
        while self._steps < end:
            self._drive(command.base_twist)
            self._drive_fingers()
            self._move_obstacles_and_objects()
            self.engine.step()
            self._steps += 1
            presses = self.engine.presses(self.world.held)
            self._update_reflexes(presses)
            self._record_touches(presses)
            pinched = between_fingers(presses) or pinched
        self.world.held = None if self._opening else pinched
        self._set_time(self.now + dt)
        self._read_engine()
        self._rest_fingers(dt)

    @property
    def _time(self) -> float:
        return self._begun + self._steps * TIMESTEP

    def _set_time(self, now: float) -> None:
        for number, walker in enumerate(self.world.walkers):
            walker.move_to(now)
            self.engine.put_walker(number, walker.pose)

    def _put_moved_objects(self) -> None:
        for number, obj in enumerate(self.world.objects):
            if obj.pose is not self._poses[number]:
                self.engine.put_object(number, obj.pose)
                self._poses[number] = obj.pose

    def _move_obstacles_and_objects(self) -> None:
        """Walkers, and moving objects until they are touched."""
        now = self._time
        self._set_time(now)
        for number, obj in enumerate(self.world.objects):
            if obj.motion is not None:
                here = obj.motion.position(now)
                velocity = (obj.motion.position(now + TIMESTEP) - here) / TIMESTEP
                self.engine.push_object(number, here[:2], velocity[:2])

    def _drive(self, twist: Array) -> None:
        """The base follows a twist (3,) with its lag, unless its bumper is pressed."""
        self._twist += _lag_share(self.description.base.lag) * (twist - self._twist)
        if self.bumper.reason is not None:
            self._twist = np.zeros(3)
        self.engine.drive(self.wheels.driven(self._twist))

    def _drive_fingers(self) -> None:
        step = self.description.gripper.speed * TIMESTEP
        self._width_now += float(np.clip(self._width_goal - self._width_now, -step, step))
        self.engine.press(self._width_now, self._force)

    def _rest_fingers(self, dt: float) -> None:
        self._still_for = self._still_for + dt if self.engine.finger_speed < _STILL_SPEED else 0.0
        if abs(self.width - self._width_goal) < _AT_WIDTH or self._still_for > _STILL_TIME:
            self.fingers_move = False

    def _update_reflexes(self, presses: list[Press]) -> None:
        self._load += _lag_share(_FILTER) * (self.engine.load - self._load)
        pushed = sum(press.force for press in presses if press.part == BASE)
        self._push_force += _lag_share(_FILTER) * (pushed - self._push_force)
        if self.bumper.is_triggered_by(self._push_force):
            hardest = _hardest([press for press in presses if press.part == BASE])
            towards = None if hardest is None else hardest.towards
            self.bumper.trip(_text(hardest, self.world.held), towards)
        force = self.engine.force_at_tool(self._load)
        if self.reflex.is_triggered_by(force):
            on_arm = [press for press in presses if press.part != BASE]
            text = _text(_hardest(on_arm), self.world.held)
            self.reflex.trip(f"{text} with {force:.0f} N")
            self.engine.relax()

    def _record_touches(self, presses: list[Press]) -> None:
        for press in presses:
            if press.force < (_SETTING_DOWN if press.part == HELD else _TOUCH):
                continue
            if isinstance(press.owner, SimObject):
                press.owner.motion = None
                if press.part == FINGERS:  # that is what they are for
                    continue
            text = _text(press, self.world.held)
            self._note_touch(press.part, press.thing, text, self._time)

    def _read_engine(self) -> None:
        engine = self.engine
        (x, y, heading), (vx, vy, w), self.q, self.qd = engine.state()
        self.wTb = se3_of(Pose2D(x, y, heading))
        along, aside = rotate(-heading, vx, vy)
        sideways = aside if self._model.n_base == 3 else 0.0  # as odometry tells
        self.base_twist = self.wheels.told(np.array([along, sideways, w]))
        opening = self.description.gripper.opening
        self.width = float(np.clip(engine.width, 0.0, opening))
        for number, obj in enumerate(self.world.objects):
            obj.pose = self._poses[number] = engine.object_pose(number)


class ForceReflex(Reflex):
    """Trips on a force above a limit [N]; clearing it forgives the present one while it shrinks."""

    def __init__(self, limit: float) -> None:
        super().__init__()
        self._limit = limit
        self._allowed = limit
        self._force = 0.0

    def is_triggered_by(self, force: float) -> bool:
        """Whether a force [N] stops the part now."""
        self._force = force
        self._allowed = max(self._limit, min(self._allowed, force + _MARGIN))
        return self.reason is None and force > self._allowed

    def clear(self) -> None:
        """Let the part move again."""
        super().clear()
        self._allowed = max(self._limit, self._force + _MARGIN)


def _lag_share(lag: float) -> float:
    """Share of a step that a first-order lag [s] follows in one `TIMESTEP`."""
    return 1.0 - exp(-TIMESTEP / lag)


def _hardest(presses: list[Press]) -> Press | None:
    return max(presses, key=lambda press: press.force, default=None)


def _text(press: Press | None, held: SimObject | None) -> str:
    if press is None:
        return "the arm met something"
    if press.part == HELD and held is not None:
        return f"{held.name} in the hand hit {press.thing}"
    who = press.part if press.part.startswith("link") else f"the {press.part}"
    return f"{who} hit {press.thing}"
