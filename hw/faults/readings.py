"""Faults that are seen in readings."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from math import cos, inf, pi, radians, sin

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from hw.clock import WallClock
from hw.faults.effect import Effect, Site
from hw.state import DepthFrame, Fault, RobotState


class Reported(Effect):
    """The robot reports a fault, and the gate brakes.

    Args:
        fault: what it reports.
    """

    def __init__(self, fault: Fault) -> None:
        self._fault = fault

    def reading(self, state: RobotState) -> RobotState:
        """With the fault among its own."""
        return replace(state, faults=(*state.faults, self._fault))


class ComesBack(Reported):
    """The robot reports a fault, and again some time after each of its first recoveries.

    Args:
        fault: what it reports.
        after: how long after a recovery [s].
        times: how often it comes back.
    """

    def __init__(self, fault: Fault, after: float, times: int) -> None:
        super().__init__(fault)
        self._after, self._left = after, times
        self._quiet_until = -inf

    def recovered(self) -> None:
        """It is gone for a while; in the end for good."""
        self._quiet_until = self.site.now + (self._after if self._left > 0 else inf)
        self._left -= 1

    def reading(self, state: RobotState) -> RobotState:
        """With the fault among its own, unless it is gone now."""
        return state if state.stamp < self._quiet_until else super().reading(state)


class FrozenState(Effect):
    """Every reading shows what the first one showed, with a fresh stamp."""

    _first: RobotState | None = None

    def reading(self, state: RobotState) -> RobotState:
        """The first reading, as if it had been measured now."""
        self._first = self._first or state
        return replace(self._first, stamp=state.stamp, stamps=state.stamps)


class FrozenStamps(Effect):
    """Every reading claims to be as old as the first one."""

    _first: RobotState | None = None

    def reading(self, state: RobotState) -> RobotState:
        """The reading with the stamps of the first one."""
        self._first = self._first or state
        return replace(state, stamp=self._first.stamp, stamps=self._first.stamps)


class LateReadings(Effect):
    """Readings arrive late, with the stamps of when they were measured.

    Args:
        delay: from the measurement to the arrival [s].
    """

    def __init__(self, delay: float) -> None:
        self._delay = delay
        self._under_way: deque[RobotState] = deque()

    def reading(self, state: RobotState) -> RobotState:
        """The newest one that has arrived."""
        self._under_way.append(state)
        arrived = state.stamp - self._delay + 1e-9
        while len(self._under_way) > 1 and self._under_way[1].stamp <= arrived:
            self._under_way.popleft()
        return self._under_way[0]


class NotANumber(Effect):
    """The joint positions of every reading are NaN."""

    def reading(self, state: RobotState) -> RobotState:
        """The reading without joint positions."""
        return replace(state, q=np.full_like(state.q, np.nan))


class SlowReading(Effect):
    """Reading the robot blocks.

    Args:
        seconds: for how long, in real time [s].
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds

    def reading(self, state: RobotState) -> RobotState:
        """The reading, after a while."""
        WallClock().sleep_until(self._seconds)
        return state


class ReadingFails(Effect):
    """Reading the robot raises an exception.

    Args:
        error: makes it.
    """

    def __init__(self, error: Callable[[], Exception]) -> None:
        self._error = error

    def reading(self, state: RobotState) -> RobotState:
        """Never returns."""
        raise self._error()


class _Displaced(Effect):
    """The base believes to be elsewhere; the camera's poses, made from it, are wrong alike."""

    _offset = SE3.Identity()
    """The pose that is told times the inverse of the true one, in the world."""

    def reading(self, state: RobotState) -> RobotState:
        """The reading at the wrong place."""
        return replace(state, wTb=self._offset * state.wTb)

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        """The frame from the wrong place."""
        return frame and replace(frame, wTc=self._offset * frame.wTc)


class LocalisationJump(_Displaced):
    """The base believes to be elsewhere from one reading to the next, and back when it is cleared.

    Args:
        distance: how far, in a random direction [m].
        angle_deg: how much it believes to be turned.
    """

    def __init__(self, distance: float, angle_deg: float) -> None:
        self._distance, self._angle = distance, radians(angle_deg)

    def begin(self, site: Site) -> None:
        """Choose the direction."""
        super().begin(site)
        towards = site.rng.uniform(-pi, pi)
        wTb = site.state.wTb
        jump = self._distance * np.array([cos(towards), sin(towards), 0.0])
        turn = pin.rpy.rpyToMatrix(0.0, 0.0, self._angle * float(site.rng.choice((-1.0, 1.0))))
        wrong = SE3(turn @ wTb.rotation, wTb.translation + jump)
        self._offset = wrong * wTb.inverse()


class LocalisationDrift(_Displaced):
    """The base overestimates how far it drives; cleared, it knows again where it is.

    Args:
        share: of the distance that is added to it.
    """

    def __init__(self, share: float) -> None:
        self._share = share
        self._before: tuple[SE3, SE3] | None = None

    def reading(self, state: RobotState) -> RobotState:
        """The reading where the base believes to be."""
        true, told = self._before or (state.wTb, state.wTb)
        step = true.inverse() * state.wTb
        told = told * SE3(step.rotation, (1.0 + self._share) * step.translation)
        self._before, self._offset = (state.wTb, told), told * state.wTb.inverse()
        return super().reading(state)
