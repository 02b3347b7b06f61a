"""Kinematic robot: follows commands with lag; a step that makes a contact is taken back."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import Command
from hw.sim.body import Reflex, SimBody
from hw.sim.collisions import Collisions, Contact
from hw.sim.sim_object import SimObject
from hw.sim.sim_robot_shapes import BASE, HAND_TOLERANCE

_SLIPS = 0.005  # motion of the hand until fingers that press without holding slip off [m]
_DEEPENING = 0.002  # by which a forgiven contact may deepen [m]


class KinematicBody(SimBody):
    """Moves as commanded, with a first-order lag, until it hits something."""

    reflex: ContactReflex
    bumper: ContactReflex

    def _begin(self) -> None:
        import scipy.optimize  # noqa: F401  # not in the tick in which the fingers first close

        self.reflex = ContactReflex()
        self.bumper = ContactReflex()
        self._width_goal = self.width
        self._pressing_from: SE3 | None = None
        self._wanted_width = self.width
        self._holds = False
        self._slipping = False
        self._collisions = Collisions(self._model, self.world)

    def _grip(self, width: float, force: float) -> None:
        """Closing stops at the width that the contacts decide, at the pose where it starts."""
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
        """First-order lag on every axis, then exact motion along the resulting arc."""
        self._set_time(self.now + dt)
        before, q_before = self.wTb, self.q
        base_lag, arm_lag = self.description.base.lag, self.description.arm.lag
        self.base_twist = self.base_twist + (1.0 - exp(-dt / base_lag)) * (
            command.base_twist - self.base_twist
        )
        if self.bumper.reason:
            self.base_twist = np.zeros(3)
        vx, vy, w = self.wheels.driven(self.base_twist) * dt
        self.wTb = self.wTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))
        if self.reflex.reason:
            self.qd = np.zeros(len(self.q))
        else:
            self.qd = self.qd + (1.0 - exp(-dt / arm_lag)) * (command.qd - self.qd)
            self.q = self.q + self.qd * dt
        self._move_fingers(self.description.gripper.speed * dt)
        self._slip()
        self._collide(before, q_before, self.now + dt)
        if self.world.held is not None:
            self.world.carry(self.wTe)
            self.world.settle()

    def _set_time(self, now: float) -> None:
        self.world.move_to(now)

    def _collide(self, wTb: SE3, q: np.ndarray, now: float) -> None:
        """Take back the motion since wTb and q (j,) that has made a contact."""
        base, arm = self._contacts(now)
        if self.bumper.is_triggered_by(base):
            self.bumper.trip_on(base)
            self.wTb, self.base_twist = wTb, np.zeros(3)
            base, arm = self._contacts(now)
        if self.reflex.is_triggered_by(arm):
            self.reflex.trip_on(arm)
            self.q, self.qd = q, np.zeros(len(self.q))
            base, arm = self._contacts(now)
        if self.reflex.is_triggered_by(arm):  # the base has pushed the arm there
            for one in arm:
                if one.excess > 0.0 and isinstance(one.owner, SimObject):
                    self.world.push(one.owner, one.towards, one.depth)
            base, arm = self._contacts(now)
            if self.reflex.is_triggered_by(arm):
                self.wTb, self.base_twist = wTb, np.zeros(3)
                base, arm = self._contacts(now)
        self.bumper.end_step(base)
        self.reflex.end_step(arm)

    def _move_fingers(self, step: float) -> None:
        """A step towards the wanted width; slipping fingers slide along the object."""
        if self._holds and self.world.held is None:  # somebody took it out of the hand
            self._holds, self._width_goal = False, self._wanted_width
        width = self.width + min(max(self._width_goal - self.width, -step), step)
        # They touch it within the tolerance of a contact.
        pressed = max(0.0, width - 2.0 * HAND_TOLERANCE)
        if self._slipping and self.world.collision(self.hand, pressed):
            width = self.width
        self.fingers_move = width != self.width
        self.width = width

    def _slip(self) -> None:
        """Slip off an object that is pressed on without being held, when the hand moves off."""
        if self._pressing_from is not None:
            moved = np.linalg.norm(self.wTe.translation - self._pressing_from.translation)
            if moved > _SLIPS:
                self._slipping, self._pressing_from = True, None
                self._width_goal = self._wanted_width

    def _contacts(self, now: float) -> tuple[list[Contact], list[Contact]]:
        contacts = self._collisions.find(self.wTb, self.q, self.width)
        for one in contacts:
            if one.excess > 0.0:
                self._note_touch(one.part, one.thing, one.text, now)
        return (
            [one for one in contacts if one.part == BASE],
            [one for one in contacts if one.part != BASE],
        )


class ContactReflex(Reflex):
    """Trips on every contact deeper than its tolerance that is not forgiven.

    A step that trips it is taken back. Clearing it forgives the present contacts, each at its
    depth: the robot may slide along or away. A forgiven contact may only become shallower; if it
    deepens, or comes back after the two were apart, the reflex trips again.
    """

    def __init__(self) -> None:
        super().__init__()
        self._present: dict[tuple[str, str], float] = {}  # excess of each contact [m]
        self._forgiven: dict[tuple[str, str], float] = {}

    def is_triggered_by(self, contacts: Sequence[Contact]) -> bool:
        """Whether any of the contacts is not forgiven."""
        return any(self._is_new(one) for one in contacts)

    def trip_on(self, contacts: Sequence[Contact]) -> None:
        """Stop on the deepest of the contacts that are not forgiven, unless stopped already."""
        if self.reason is None:
            new = (one for one in contacts if self._is_new(one))
            deepest = max(new, key=lambda one: one.excess)
            self.trip(deepest.text, deepest.towards)

    def end_step(self, contacts: Sequence[Contact]) -> None:
        """A step has ended with these contacts."""
        self._present = {(one.part, one.thing): max(0.0, one.excess) for one in contacts}
        self._forgiven = {
            key: min(excess, self._present[key])
            for key, excess in self._forgiven.items()
            if key in self._present
        }

    def clear(self) -> None:
        """Let the part move again."""
        super().clear()
        self._forgiven = self._present | self._forgiven

    def _is_new(self, contact: Contact) -> bool:
        forgiven = self._forgiven.get((contact.part, contact.thing))
        return contact.excess > (0.0 if forgiven is None else forgiven + _DEEPENING)
