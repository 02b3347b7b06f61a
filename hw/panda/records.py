"""What the processes of arm and hand tell and are told: one record each, all of them numbers."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Self

from hw.panda.generation import Joints
from hw.processes.mailbox import Mailbox

_ZERO = (0.0,) * 7


class Mode(IntEnum):
    """What the arm is doing, as the vendor numbers it."""

    OTHER = 0
    IDLE = 1
    MOVE = 2
    GUIDING = 3
    REFLEX = 4
    USER_STOPPED = 5
    RECOVERING = 6


ARM_READING = struct.Struct("<dQB7d7d7dQddd480s")
ARM_COMMAND = struct.Struct("<Qd7d")
"""Number, when it was given (0: it is a stop) [s], velocities [rad/s]."""
HAND_READING = struct.Struct("<ddd?B")
HOMED = 0.05
"""A hand that was not homed since it was switched on tells a smaller opening than this [m]."""
CLOSED = 2e-3
"""A width below this means: closed, with nothing in between [m]."""
OPEN = 0.075
"""A width above this means: open, with nothing in between, unless the hand says so [m]."""
REACHED = 2e-3
"""Fingers nearer to a width than this are there [m]."""


@dataclass(frozen=True, kw_only=True)
class ArmReading:
    """What the arm's process knows of the arm."""

    stamp: float
    """When the state arrived [s]."""
    time: int
    """Of the arm's own clock [ms]."""
    mode: Mode
    q: Joints
    """(7,) [rad]"""
    qd: Joints
    """(7,) [rad/s]"""
    commanded: Joints = _ZERO
    """(7,) velocities that the arm was commanded last [rad/s]."""
    lost: int = 0
    """States that did not arrive in time, in all motions [ms]."""
    success_rate: float = 0.0
    """Share of the last 100 commands that reached the arm in time; 0 without a motion."""
    hand_mass: float = 0.0
    """Of the end effector, as Desk was told [kg]."""
    load: float = 0.0
    """Of what it is said to carry beside [kg]."""
    trouble: str = ""
    """Why it has stopped and waits for a recovery."""

    def put(self, mailbox: Mailbox) -> None:
        """Tell it."""
        mailbox.put(
            self.stamp,
            self.time,
            self.mode,
            *self.q,
            *self.qd,
            *self.commanded,
            self.lost,
            self.success_rate,
            self.hand_mass,
            self.load,
            self.trouble.encode()[:480],
        )

    @classmethod
    def get(cls, mailbox: Mailbox) -> Self | None:
        """The newest one."""
        if (values := mailbox.get()) is None:
            return None
        stamp, time, mode, *joints, lost, success_rate, hand_mass, load, trouble = values
        return cls(
            stamp=stamp,
            time=time,
            mode=Mode(mode),
            q=tuple(joints[:7]),
            qd=tuple(joints[7:14]),
            commanded=tuple(joints[14:]),
            lost=lost,
            success_rate=success_rate,
            hand_mass=hand_mass,
            load=load,
            trouble=trouble.rstrip(b"\0").decode(errors="replace"),
        )


@dataclass(frozen=True, kw_only=True)
class HandReading:
    """What the hand's process knows of the hand."""

    stamp: float
    """When the state arrived [s]."""
    width: float
    """Between the pads [m]."""
    opening: float
    """Largest width, as homing found it; 0 before [m]."""
    is_grasped: bool
    """As the hand says; after a grasp that allows every width this is so with an empty hand."""
    temperature: int
    """[degrees C]"""

    @property
    def is_homed(self) -> bool:
        """Whether the hand was homed since it was switched on."""
        return self.opening >= HOMED

    @property
    def may_hold(self) -> bool:
        """Whether something may be between the fingers: a hand without power forgets a grasp."""
        return self.width > CLOSED and (self.is_grasped or self.width < OPEN)

    def put(self, mailbox: Mailbox) -> None:
        """Tell it."""
        mailbox.put(self.stamp, self.width, self.opening, self.is_grasped, self.temperature)

    @classmethod
    def get(cls, mailbox: Mailbox) -> Self | None:
        """The newest one."""
        if (values := mailbox.get()) is None:
            return None
        stamp, width, opening, is_grasped, temperature = values
        return cls(
            stamp=stamp,
            width=width,
            opening=opening,
            is_grasped=is_grasped,
            temperature=temperature,
        )
