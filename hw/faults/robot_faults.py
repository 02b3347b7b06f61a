"""Faults of readings and of commands: base, arm, gripper and localisation."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import cos, inf, pi, radians, sin

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import Command
from hw.clock import WallClock
from hw.faults.effect import Effect, Injectable, Site
from hw.robot import HardwareError
from hw.state import Array, DepthFrame, Fault, FaultKind, RobotState

_COMES_BACK_AFTER, _COMES_BACK_TIMES = 0.3, 3  # [s]
_READING_DELAY = 0.05  # [s]
_READING_DURATION = 0.03  # of real time [s]
_JUMP, _JUMP_ANGLE = 0.2, radians(15.0)  # [m, rad]
_DRIFT = 0.03  # share of the driven distance
_TOO_FAST = 3.0  # times the commanded speed
_LONGEST_PERIOD = 0.02  # for which a command counts [s]


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


class _FrozenState(Effect):
    _first: RobotState | None = None

    def reading(self, state: RobotState) -> RobotState:
        self._first = self._first or state
        return replace(self._first, stamp=state.stamp, stamps=state.stamps)


class _FrozenStamps(Effect):
    _first: RobotState | None = None

    def reading(self, state: RobotState) -> RobotState:
        self._first = self._first or state
        return replace(state, stamp=self._first.stamp, stamps=self._first.stamps)


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


class _NotANumber(Effect):
    def reading(self, state: RobotState) -> RobotState:
        return replace(state, q=np.full_like(state.q, np.nan))


class _SlowReading(Effect):
    def reading(self, state: RobotState) -> RobotState:
        WallClock().sleep_until(_READING_DURATION)
        return state


class _Displaced(Effect):
    """The localised pose is wrong, and so are the camera poses, which are made from it."""

    _offset = SE3.Identity()  # wrong pose times the inverse of the true one, in the world

    def reading(self, state: RobotState) -> RobotState:
        return replace(state, wTb=self._offset * state.wTb)

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        return frame and replace(frame, wTc=self._offset * frame.wTc)


class _LocalisationJump(_Displaced):
    def begin(self, site: Site) -> None:
        super().begin(site)
        towards = site.rng.uniform(-pi, pi)
        wTb = site.state.wTb
        jump = _JUMP * np.array([cos(towards), sin(towards), 0.0])
        turn = pin.rpy.rpyToMatrix(0.0, 0.0, _JUMP_ANGLE * float(site.rng.choice((-1.0, 1.0))))
        wrong = SE3(turn @ wTb.rotation, wTb.translation + jump)
        self._offset = wrong * wTb.inverse()


class _LocalisationDrift(_Displaced):
    _before: tuple[SE3, SE3] | None = None

    def reading(self, state: RobotState) -> RobotState:
        true, drifted = self._before or (state.wTb, state.wTb)
        step = true.inverse() * state.wTb
        drifted = drifted * SE3(step.rotation, (1.0 + _DRIFT) * step.translation)
        self._before, self._offset = (state.wTb, drifted), drifted * state.wTb.inverse()
        return super().reading(state)


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


class _ReadingFails(Effect):
    def __init__(self, error: Callable[[], Exception]) -> None:
        self._error = error

    def reading(self, state: RobotState) -> RobotState:
        raise self._error()


class _SendingFails(_ReadingFails):
    def reading(self, state: RobotState) -> RobotState:
        return state

    def command(self, command: Command) -> Command:
        raise self._error()


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

ROBOT_FAULTS = (
    _reported(FaultKind.REFLEX, "reflex of the arm", clearable=True),
    _reported(FaultKind.BUMPER, "bumper of the base", clearable=True),
    _reported(FaultKind.EMERGENCY_STOP, "emergency stop"),
    _reported(FaultKind.STALE_POSE, "stale pose of the base"),
    Injectable(
        "bumper again",
        partial(_ComesBack, _bumped),
        "the robot reports: bumper of the base, and again after each of three recoveries",
    ),
    Injectable("gripper dead", _GripperDead, "the fingers do not move"),
    Injectable("gripper halfway", _GripperHalfway, "the fingers stop half way"),
    Injectable("state frozen", _FrozenState, "one reading, again, with fresh stamps"),
    Injectable("stamps frozen", _FrozenStamps, "the stamps of readings stand still"),
    Injectable("state nan", _NotANumber, "the joint positions read NaN"),
    Injectable("localisation jump", _LocalisationJump, "the base believes to be 0.2 m and 15° off"),
    Injectable(
        "localisation drift", _LocalisationDrift, "the base adds 3 % to the distance that it drives"
    ),
    Injectable("base ignores commands", _BaseIgnoresCommands, "the base rolls to a stop"),
    Injectable("base too fast", _BaseTooFast, "the base is three times as fast as told"),
    Injectable("readings late", _LateReadings, "readings arrive 50 ms late"),
    Injectable(
        "readings slow", _SlowReading, "every reading blocks the loop for 30 ms of real time"
    ),
    Injectable("reading fails", partial(_ReadingFails, _no_answer), "`read` raises HardwareError"),
    Injectable("reading breaks", partial(_ReadingFails, _lost), "`read` raises an OSError"),
    Injectable("sending fails", partial(_SendingFails, _no_answer), "`send` raises HardwareError"),
)
