"""What a fault does while it lasts, and what it may know and touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from controller import Command
from hw.state import DepthFrame, RobotState
from hw.truth import DisturbableWorld
from robots import RobotDescription


@dataclass(kw_only=True, eq=False)
class Site:
    """Where faults happen; one for all faults of a robot."""

    description: RobotDescription
    state: RobotState  # The newest reading as the robot gave it, without any fault
    world: DisturbableWorld | None  # None where nobody can interfere with the world, as on hardware
    homes: dict[str, SE3]  # Where each object of the world was to begin with
    rng: np.random.Generator

    @property
    def now(self) -> float:
        """When that reading was measured, on the session's clock [s]."""
        return self.state.stamp


class Effect:
    """One fault from its injection to its end. This one does nothing.

    All methods are called on the loop, but `frame`, which is called where images are taken.
    """

    site: Site

    def begin(self, site: Site) -> None:
        """It starts; `site` is kept up to date."""
        self.site = site

    def end(self) -> None:
        """It was cleared."""

    def recovered(self) -> None:
        """Somebody has asked the robot to recover."""

    def reading(self, state: RobotState) -> RobotState:
        """A reading of the robot, as the fault lets it through."""
        return state

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        """A frame of the camera, as the fault lets it through."""
        return frame

    def command(self, command: Command) -> Command:
        """What the robot does instead of a command; it claims that it does what it was told."""
        return command

    def grip(self, width: float) -> float | None:
        """The width [m] to which the fingers really go; None if they do not move."""
        return width
