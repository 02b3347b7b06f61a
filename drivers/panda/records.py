"""Shared-memory records of the processes of arm and hand."""

import struct
from enum import IntEnum
from typing import NamedTuple, Self

from drivers.panda.library import Joints
from drivers.processes.mailbox import Mailbox


class Mode(IntEnum):
    """Mode of the arm, as the vendor numbers it."""

    OTHER = 0
    IDLE = 1
    MOVE = 2
    GUIDING = 3
    REFLEX = 4
    USER_STOPPED = 5
    RECOVERING = 6


ARM_READING = struct.Struct("<dB7d7dQdd480s")
ARM_COMMAND = struct.Struct("<Qd7d")  # number, stamp (0: a stop) [s], velocities [rad/s]
HAND_READING = struct.Struct("<ddd?B")
HOMED = 0.05  # a hand that was not homed since power-on reports a smaller opening than this [m]
CLOSED = 2e-3  # a width below this means: closed, with nothing in between [m]
OPEN = 0.075  # a larger width means open, with nothing in between, if not grasped [m]
REACHED = 2e-3  # tolerance of a width [m]


class ArmReading(NamedTuple):
    """State of the arm."""

    stamp: float  # time of arrival [s]
    mode: Mode
    q: Joints  # (7,) [rad]
    qd: Joints  # (7,) [rad/s]
    lost: int  # states that did not arrive in time, in all motions [ms]
    hand_mass: float  # mass of the end effector, as set in Desk [kg]
    load: float  # mass of the load, as set in Desk [kg]
    trouble: str  # why it has stopped and waits for a recovery

    def put(self, mailbox: Mailbox) -> None:
        """Publish it."""
        numbers = (*self[:2], *self.q, *self.qd, self.lost, self.hand_mass, self.load)
        mailbox.put(*numbers, self.trouble.encode()[:480])

    @classmethod
    def get(cls, mailbox: Mailbox) -> Self | None:
        """The newest one; None before the first."""
        if (values := mailbox.get()) is None:
            return None
        stamp, mode, *joints, lost, hand_mass, load, trouble = values
        q, qd, text = tuple(joints[:7]), tuple(joints[7:]), trouble.rstrip(b"\0")
        told = text.decode(errors="replace")
        return cls(stamp, Mode(mode), q, qd, lost, hand_mass, load, told)


class HandReading(NamedTuple):
    """State of the hand."""

    stamp: float  # time of arrival [s]
    width: float  # between the pads [m]
    opening: float  # largest width, as found by homing; 0 before [m]
    is_grasped: bool  # as it reports, also when empty
    temperature: int  # [degrees C]

    @property
    def is_homed(self) -> bool:
        """Whether the hand was homed since power-on."""
        return self.opening >= HOMED

    @property
    def may_hold(self) -> bool:
        """Whether an object may be between the fingers: without power the hand forgets a grasp."""
        return self.width > CLOSED and (self.is_grasped or self.width < OPEN)

    @classmethod
    def get(cls, mailbox: Mailbox) -> Self | None:
        """The newest one; None before the first."""
        values = mailbox.get()
        return None if values is None else cls(*values)
