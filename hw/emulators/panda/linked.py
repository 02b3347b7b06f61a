"""Joints and fingers of a simulated robot in another process, over shared memory.

The emulated arm runs at 1 kHz in a process of its own; the simulated world is slower. `LinkedBody`
is the arm's end, which writes commands and reads the state of the world; `ArmLink` the world's.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from dataclasses import dataclass

from hw.clock import stopwatch
from hw.emulators.panda.parts import OPENING, PERIOD, READY
from hw.processes.mailbox import Mailbox, open_memory, share_memory

_WANTED = struct.Struct("<d7dQQdd?")
"""Stamp [s], commanded travel of each joint [rad], releases, grips, width [m], force [N], stop."""
_THERE = struct.Struct("<d7d7d?QQd")
"""Stamp [s], positions [rad], velocities [rad/s], whether a contact stops it, releases that are
done, number of the last grip that has ended, width [m]."""
_AHEAD = 0.02  # longest extrapolation of positions [s]


class LinkedBody:
    """`Joints` and `Fingers` of the simulated robot, over one shared memory."""

    def __init__(self, memory: int) -> None:
        shared = open_memory(memory)
        self._wanted, self._there = Mailbox(shared, 0, _WANTED), Mailbox(shared, 1, _THERE)
        self._way = [0.0] * 7
        self._releases = self._grips = 0
        self._grip = (OPENING, 0.0, False)
        self._gripping = False
        self.q: tuple[float, ...]
        self.qd: tuple[float, ...]
        _, self.q, self.qd, _, _ = self._state()

    def follow(self, qd: tuple[float, ...]) -> str:
        """Advance by one period; the error of a contact."""
        self._way = [way + PERIOD * v for way, v in zip(self._way, qd, strict=True)]
        self._wanted.put(stopwatch(), *self._way, self._releases, self._grips, *self._grip)
        at, q, self.qd, is_stopped, _ = self._state()
        ahead = min(max(0.0, stopwatch() - at), _AHEAD)
        self.q = tuple([p + ahead * v for p, v in zip(q, self.qd, strict=True)])
        return "cartesian_reflex" if is_stopped else ""

    def release(self) -> None:
        """Forget a contact."""
        self._releases += 1

    @property
    def width(self) -> float:
        """Between the pads [m]."""
        return self._state()[4]

    def close_to(self, width: float, step: float, force: float) -> bool:
        """Whether the fingers have come to rest; their speed is that of the world."""
        return self._command_fingers(width, force)

    def stop(self) -> None:
        """Stop the fingers where they are."""
        self._command_fingers(self.width, 0.0, stops=True)

    def _command_fingers(self, width: float, force: float, *, stops: bool = False) -> bool:
        """Command the fingers, unless that is commanded already; whether they have ended."""
        wanted = (width, force, stops)
        if not self._gripping or wanted != self._grip:
            self._grips, self._grip, self._gripping = self._grips + 1, wanted, True
        there = self._there.get()
        ended = there is not None and there[17] == self._grips
        self._gripping = not ended
        return ended

    def _state(self) -> tuple[float, tuple[float, ...], tuple[float, ...], bool, float]:
        """State of the world: stamp, positions, velocities, whether in contact, width."""
        values = self._there.get()
        if values is None:
            return (stopwatch(), READY, (0.0,) * 7, False, OPENING)
        has_met = values[15] and values[16] == self._releases
        return (values[0], values[1:8], values[8:15], has_met, values[18])


@dataclass(frozen=True)
class Wanted:
    """Commands of the arm to the world."""

    at: float  # [s of `stopwatch`]
    way: tuple[float, ...]  # (7,) commanded travel of the joints so far [rad]
    releases: int  # number of recoveries
    grips: int  # number of finger commands; the last one is:
    width: float  # [m]
    force: float  # [N]
    stops: bool  # whether the fingers are to stop


class ArmLink:
    """The world's end: commands of arm and hand, and their state."""

    def __init__(self) -> None:
        self.memory = share_memory(2)  # descriptor, for the arm's process to inherit
        shared = open_memory(self.memory)
        self._wanted, self._there = Mailbox(shared, 0, _WANTED), Mailbox(shared, 1, _THERE)

    def wanted(self) -> Wanted | None:
        """The newest commands; None before the first."""
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
        """Publish the state."""
        self._there.put(stopwatch(), *q, *qd, is_stopped, releases, grips, width)
