"""Injected faults: their base class, and those of readings, commands and gripper."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import inf

import numpy as np
from pinocchio import SE3

from controller import Command
from hw import (
    Array,
    DepthFrame,
    DisturbableWorld,
    Fault,
    FaultKind,
    HardwareError,
    RobotState,
    WallClock,
)
from robots import RobotDescription

_COMES_BACK_AFTER, _COMES_BACK_TIMES = 0.3, 3  # [s]
_READING_DELAY = 0.05  # [s]
_READING_DURATION = 0.03  # of real time [s]
_TOO_FAST = 3.0  # times the commanded speed
_LONGEST_PERIOD = 0.02  # for which a command counts [s]


@dataclass(kw_only=True, eq=False)
class Site:
    """Access of the faults of one robot to the robot and its world."""

    description: RobotDescription
    state: RobotState  # newest reading, without any fault
    world: DisturbableWorld | None  # None on hardware
    homes: dict[str, SE3]  # initial poses of the objects
    rng: np.random.Generator

    @property
    def now(self) -> float:
        """The stamp of the newest reading [s]."""
        return self.state.stamp


class Effect:
    """One fault from its injection to its end; all but `frame` is called on the loop."""

    site: Site

    def begin(self, site: Site) -> None:
        """Start; `site` is kept up to date."""
        self.site = site

    def end(self) -> None:
        """It was cleared."""

    def recovered(self) -> None:
        """The robot was asked to recover."""

    def reading(self, state: RobotState) -> RobotState:
        """Change a reading of the robot."""
        return state

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        """Change a frame of the camera."""
        return frame

    def command(self, command: Command) -> Command:
        """Change a command; the robot reports the original one as applied."""
        return command

    def grip(self, width: float) -> float | None:
        """Change the width [m] that the fingers move to; None if they do not move."""
        return width


@dataclass(frozen=True)
class Injectable:
    """A fault that can be injected, by name."""

    name: str
    make: Callable[[], Effect]
    what: str  # for people
    clearable: bool = False  # whether `Robot.recover` clears it
    of_world: bool = False  # whether it changes the world instead of the robot


class _Reading(Effect):
    def __init__(self, change: Callable[[RobotState], RobotState]) -> None:
        self._change = change

    def reading(self, state: RobotState) -> RobotState:
        return self._change(state)


class _Reported(Effect):
    def __init__(self, fault: Fault) -> None:
        self._fault = fault

    def reading(self, state: RobotState) -> RobotState:
        return replace(state, faults=(*state.faults, self._fault))


class _ComesBack(_Reported):
    """Reported, and again some time after each of its first recoveries."""

    _times = _COMES_BACK_TIMES
    _quiet_until = -inf

    def recovered(self) -> None:
        self._quiet_until = self.site.now + (_COMES_BACK_AFTER if self._times > 0 else inf)
        self._times -= 1

    def reading(self, state: RobotState) -> RobotState:
        return state if state.stamp < self._quiet_until else super().reading(state)


class _Frozen(Effect):
    """The values of the first reading with fresh stamps, or fresh values with its stamps."""

    _first: RobotState | None = None

    def __init__(self, *, stamps: bool) -> None:
        self._stamps = stamps

    def reading(self, state: RobotState) -> RobotState:
        self._first = first = self._first or state
        values, stamped = (state, first) if self._stamps else (first, state)
        return replace(values, stamp=stamped.stamp, stamps=stamped.stamps)


class _LateReadings(Effect):
    """Readings arrive late, with the stamps of their measurement."""

    def __init__(self) -> None:
        self._queue: deque[RobotState] = deque()

    def reading(self, state: RobotState) -> RobotState:
        self._queue.append(state)
        arrived = state.stamp - _READING_DELAY + 1e-9
        while len(self._queue) > 1 and self._queue[1].stamp <= arrived:
            self._queue.popleft()
        return self._queue[0]


def _slow(state: RobotState) -> RobotState:
    WallClock().sleep_until(_READING_DURATION)
    return state


class _BaseIgnoresCommands(Effect):
    """The base rolls to a stop within its acceleration limits."""

    _twist: Array | None = None

    def begin(self, site: Site) -> None:
        super().begin(site)
        self._since = site.now

    def command(self, command: Command) -> Command:
        dt = min(self.site.now - self._since, _LONGEST_PERIOD)
        self._since = self.site.now
        step = self.site.description.limits.base_acceleration * dt
        twist = command.base_twist if self._twist is None else self._twist
        self._twist = twist - np.clip(twist, -step, step)
        return replace(command, base_twist=self._twist)


class _BaseTooFast(Effect):
    def command(self, command: Command) -> Command:
        return replace(command, base_twist=_TOO_FAST * command.base_twist)


class _Fails(Effect):
    """Reading raises an error, or sending does."""

    def __init__(self, error: Callable[[], Exception], *, sending: bool = False) -> None:
        self._error, self._sending = error, sending

    def reading(self, state: RobotState) -> RobotState:
        if not self._sending:
            raise self._error()
        return state

    def command(self, command: Command) -> Command:
        if self._sending:
            raise self._error()
        return command


class _GripperDead(Effect):
    def grip(self, width: float) -> float | None:
        return None


class _GripperHalfway(Effect):
    def grip(self, width: float) -> float | None:
        return (width + self.site.state.gripper_width) / 2.0


def _reported(kind: FaultKind, text: str, clearable: bool = False) -> Injectable:
    fault = Fault(kind=kind, text=f"{text}, injected", clearable=clearable)
    make = partial(_Reported, fault)
    return Injectable(kind.value, make, f"the robot reports: {text}", clearable=clearable)


_bumped = Fault(kind=FaultKind.BUMPER, text="bumper of the base again, injected", clearable=True)
_no_answer = partial(HardwareError, "the robot does not answer, injected")
_lost = partial(ConnectionResetError, "connection lost, injected")

_ROWS: tuple[tuple[str, Callable[[], Effect], str], ...] = (
    (
        "bumper again",
        partial(_ComesBack, _bumped),
        "the robot reports: bumper of the base, and again after each of three recoveries",
    ),
    ("gripper dead", _GripperDead, "the fingers do not move"),
    ("gripper halfway", _GripperHalfway, "the fingers stop half way"),
    ("state frozen", partial(_Frozen, stamps=False), "one reading, again, with fresh stamps"),
    ("stamps frozen", partial(_Frozen, stamps=True), "the stamps of readings stand still"),
    (
        "state nan",
        partial(_Reading, lambda state: replace(state, q=np.full_like(state.q, np.nan))),
        "the joint positions read NaN",
    ),
    ("base ignores commands", _BaseIgnoresCommands, "the base rolls to a stop"),
    ("base too fast", _BaseTooFast, "the base is three times as fast as told"),
    ("readings late", _LateReadings, "readings arrive 50 ms late"),
    (
        "readings slow",
        partial(_Reading, _slow),
        "every reading blocks the loop for 30 ms of real time",
    ),
    ("reading fails", partial(_Fails, _no_answer), "`read` raises HardwareError"),
    ("reading breaks", partial(_Fails, _lost), "`read` raises an OSError"),
    ("sending fails", partial(_Fails, _no_answer, sending=True), "`send` raises HardwareError"),
)
ROBOT_FAULTS = (
    _reported(FaultKind.REFLEX, "reflex of the arm", clearable=True),
    _reported(FaultKind.BUMPER, "bumper of the base", clearable=True),
    _reported(FaultKind.EMERGENCY_STOP, "emergency stop"),
    _reported(FaultKind.STALE_POSE, "stale pose of the base"),
    *(Injectable(*row) for row in _ROWS),
)
