"""Joints and fingers behind the emulated Panda: in free air, or those of a simulated world."""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from math import copysign, exp
from typing import Protocol

from drivers.processes.mailbox import Mailbox, open_memory, share_memory
from hw import stopwatch

PERIOD = 0.001  # of the control loop [s]
READY = (0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.7853981633974483)  # initial positions [rad]
OPENING = 0.08  # between the fingers when fully open [m]
_LAG = 0.025  # time constant of the joints [s]
_WANTED = struct.Struct("<d7dQQdd?")
"""Stamp [s], commanded travel of each joint [rad], releases, grips, width [m], force [N], stop."""
_THERE = struct.Struct("<d7d7d?QQd")
"""Stamp [s], positions [rad], velocities [rad/s], whether a contact stops it, releases that are
done, number of the last grip that has ended, width [m]."""
_AHEAD = 0.02  # longest extrapolation of positions [s]


class Joints(Protocol):
    """Seven joints that follow velocities."""

    q: tuple[float, ...]  # (7,) positions [rad]
    qd: tuple[float, ...]  # (7,) velocities [rad/s]

    def follow(self, qd: tuple[float, ...]) -> str:
        """Advance by one period with velocities (7,) [rad/s]; the error of a contact, or empty."""

    def release(self) -> None:
        """Forget a contact after a recovery."""


class Fingers(Protocol):
    """Two fingers, possibly with an object between them."""

    @property
    def width(self) -> float:
        """Between the pads [m]."""

    def close_to(self, width: float, step: float, force: float) -> bool:
        """Move towards a width by at most a step [m] with a force [N]; whether they rest."""

    def stop(self) -> None:
        """Stop where they are."""


class LaggedJoints:
    """Joints in free air; velocities follow with a first-order lag."""

    def __init__(self, q: tuple[float, ...] = READY) -> None:
        self.q = q
        self.qd: tuple[float, ...] = (0.0,) * 7
        self._share = 1.0 - exp(-PERIOD / _LAG)

    def follow(self, qd: tuple[float, ...]) -> str:
        """Advance by one period; there are no contacts."""
        share = self._share
        self.qd = tuple([v + share * (w - v) for v, w in zip(self.qd, qd, strict=True)])
        self.q = tuple([p + PERIOD * v for p, v in zip(self.q, self.qd, strict=True)])
        return ""

    def release(self) -> None:
        """There are no contacts."""


class FreeFingers:
    """Fingers with nothing, or a block of some width [m], between them."""

    def __init__(self) -> None:
        self.block: float | None = None
        self.width = OPENING

    def stop(self) -> None:
        """They move only when commanded."""

    def close_to(self, width: float, step: float, force: float) -> bool:
        """Advance by one step."""
        least = width
        if self.block is not None and self.width >= self.block:
            least = max(width, self.block)
        way = least - self.width
        self.width = least if abs(way) <= step else self.width + copysign(step, way)
        return self.width == least


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
