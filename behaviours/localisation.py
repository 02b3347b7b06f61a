"""Where the map is in the world of the odometry, and what is placed on it (REP 105)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np
from pinocchio import SE3

from hw import RobotState

Thing = TypeVar("Thing")

_STILL = 0.002  # correction, at the robot, that moves nothing on the map yet [m]


class Localisation:
    """Estimates the transform from map to odometry, and spreads its corrections.

    The world w in which everything moves is that of the odometry: smooth, and never jumping. The
    map m is where the newest estimate has it; both are the same where the robot reports no
    localised pose of its own.
    """

    def __init__(self) -> None:
        self.wTm: SE3 | None = None
        """The map in the world; None where they are the same."""
        self.mTw: SE3 | None = None
        """Its inverse."""
        self.mTb = SE3.Identity()
        """The base on the map, as read this tick."""

    def read(self, state: RobotState) -> None:
        """Take a reading."""
        self.mTb = state.wTb if self.mTw is None else self.mTw * state.wTb


class OnMap(Generic[Thing]):
    """Places on the map what the robot remembers in the world.

    Args:
        moved: (what, T) to what T moves it to.
    """

    def __init__(self, moved: Callable[[Thing, SE3], Thing]) -> None:
        self._moved = moved
        self._placed: tuple[Thing, SE3, Thing] | None = None

    def __call__(self, thing: Thing, here: Localisation) -> Thing:
        """The same object until the thing is another or the map has moved noticeably."""
        if (mTw := here.mTw) is None:
            return thing
        if self._placed is not None and self._placed[0] is thing:
            shift = self._placed[1] * mTw.actInv(here.mTb)
            if np.linalg.norm(shift.translation - here.mTb.translation) < _STILL:
                return self._placed[2]
        self._placed = thing, mTw, self._moved(thing, mTw)
        return self._placed[2]
