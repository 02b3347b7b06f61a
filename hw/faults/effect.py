"""Base class of injected faults, what they may access, and the row that names one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from config import UserError
from controller import Command
from hw.state import DepthFrame, RobotState
from hw.truth import DisturbableWorld
from robots import RobotDescription


class InjectionError(UserError):
    """A fault that cannot be injected."""


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
    """One fault from its injection to its end. The base class has no effect.

    All methods are called on the loop, but `frame`, which is called where images are taken.
    """

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
