"""Joints and fingers that are those of a simulated robot in another process.

The arm's clock ticks 1000 times a second in a process of its own; the world behind it is slower and
has other things to do. They share memory: the arm tells how far its joints and fingers are wanted,
the world where they are. `LinkedJoints` and `LinkedFingers` are the arm's end of it, `ArmLink` is
the world's.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass

from hw.clock import stopwatch
from hw.emulators.panda.parts import OPENING, PERIOD, READY
from hw.processes.mailbox import Mailbox, open_memory, share_memory

_WANTED = struct.Struct("<d7dQQdd?")
"""When [s], way of each joint [rad], releases, grips, width [m], force [N], whether it stops."""
_THERE = struct.Struct("<d7d7d?QQd")
"""When [s], positions [rad], velocities [rad/s], whether it is stopped by a contact, releases that
are done, the last grip that has ended, width [m]."""
_AHEAD = 0.02
"""The newest positions are carried on with their velocities for so long at most [s]."""
MET = "cartesian_reflex"
"""The error with which the arm stops on a contact."""


class LinkedBody:
    """What joints and fingers of one arm share: a memory.

    Args:
        memory: a descriptor of it.
    """

    def __init__(self, memory: int) -> None:
        shared = open_memory(memory)
        self._wanted, self._there = Mailbox(shared, 0, _WANTED), Mailbox(shared, 1, _THERE)
        self._way = [0.0] * 7
        self._releases = self._grips = 0
        self._grip = (OPENING, 0.0, False)
        self._gripping = False
        self.joints, self.fingers = LinkedJoints(self), LinkedFingers(self)

    def tell(self) -> None:
        """What is wanted now."""
        self._wanted.put(stopwatch(), *self._way, self._releases, self._grips, *self._grip)

    def move(self, qd: tuple[float, ...]) -> None:
        """The joints are to go on for one period."""
        self._way = [way + PERIOD * v for way, v in zip(self._way, qd, strict=True)]
        self.tell()

    def release(self) -> None:
        """What was met is forgotten."""
        self._releases += 1

    def grip(self, width: float, force: float, *, stops: bool = False) -> bool:
        """Have the fingers moved, if that is not asked for already; whether they have ended."""
        wanted = (width, force, stops)
        if not self._gripping or wanted != self._grip:
            self._grips, self._grip, self._gripping = self._grips + 1, wanted, True
        there = self._there.get()
        ended = there is not None and there[17] == self._grips
        self._gripping = not ended
        return ended

    def there(self) -> tuple[float, tuple[float, ...], tuple[float, ...], bool, float]:
        """Where it is: when, positions, velocities, whether it has met something, and width."""
        values = self._there.get()
        if values is None:
            return (stopwatch(), READY, (0.0,) * 7, False, OPENING)
        has_met = values[15] and values[16] == self._releases
        return (values[0], values[1:8], values[8:15], has_met, values[18])


class LinkedJoints:
    """Seven joints of the simulated robot."""

    def __init__(self, body: LinkedBody) -> None:
        self._body = body
        self.q: tuple[float, ...]
        self.qd: tuple[float, ...]
        _, self.q, self.qd, _, _ = body.there()

    def follow(self, qd: tuple[float, ...]) -> str:
        """One period; the world tells whether they have met something."""
        self._body.move(qd)
        at, q, speeds, is_stopped, _ = self._body.there()
        ahead = min(max(0.0, stopwatch() - at), _AHEAD)
        self.q = tuple([p + ahead * v for p, v in zip(q, speeds, strict=True)])
        self.qd = speeds
        return MET if is_stopped else ""

    def release(self) -> None:
        """The arm has been recovered."""
        self._body.release()


class LinkedFingers:
    """Two fingers of the simulated robot."""

    def __init__(self, body: LinkedBody) -> None:
        self._body = body

    @property
    def width(self) -> float:
        """Between the pads [m]."""
        return self._body.there()[4]

    def close_to(self, width: float, step: float, force: float) -> bool:
        """Whether they have come to rest on their way; their speed is that of the world."""
        return self._body.grip(width, force)

    def stop(self) -> None:
        """Where they are."""
        self._body.grip(self.width, 0.0, stops=True)


@dataclass(frozen=True)
class Wanted:
    """What the arm wants of the world."""

    at: float
    """[s of `stopwatch`]"""
    way: tuple[float, ...]
    """(7,) that the joints were commanded so far [rad]."""
    releases: int
    """How often the arm was recovered."""
    grips: int
    """How often the fingers were told something; the last time:"""
    width: float
    """[m]"""
    force: float
    """[N]"""
    stops: bool
    """Whether they are to stop where they are."""


class ArmLink:
    """The world's end: what is wanted of arm and hand, and where they are."""

    def __init__(self) -> None:
        self.memory = share_memory(2)
        """A descriptor, for the arm's process to inherit."""
        shared = open_memory(self.memory)
        self._wanted, self._there = Mailbox(shared, 0, _WANTED), Mailbox(shared, 1, _THERE)

    def wanted(self) -> Wanted | None:
        """The newest; None before the first."""
        values = self._wanted.get()
        return None if values is None else Wanted(values[0], values[1:8], *values[8:])

    def tell(
        self,
        q: Iterable[float],
        qd: Iterable[float],
        width: float,
        *,
        is_stopped: bool,
        releases: int,
        grips: int,
    ) -> None:
        """Where joints (7,) [rad, rad/s] and fingers [m] are now.

        Args:
            q: positions.
            qd: velocities.
            width: between the pads.
            is_stopped: whether a contact keeps the arm from moving.
            releases: that are done.
            grips: number of the last one that has ended.
        """
        self._there.put(stopwatch(), *q, *qd, is_stopped, releases, grips, width)
