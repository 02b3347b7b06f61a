"""Faults of what is commanded: base, arm and fingers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from controller import Command
from hw.faults.effect import Effect, Site
from hw.state import Array

_LONGEST_PERIOD = 0.02  # A command counts for this long at most [s]


class BaseIgnoresCommands(Effect):
    """The base rolls out within its own acceleration limits, and says nothing."""

    _twist: Array | None = None

    def begin(self, site: Site) -> None:
        """From the first command on."""
        super().begin(site)
        self._since = site.now

    def command(self, command: Command) -> Command:
        """The arm's part of it."""
        dt = min(self.site.now - self._since, _LONGEST_PERIOD)
        self._since = self.site.now
        step = self.site.description.limits.base_acceleration * dt
        twist = command.base_twist if self._twist is None else self._twist
        self._twist = twist - np.clip(twist, -step, step)
        return replace(command, base_twist=self._twist)


class BaseTooFast(Effect):
    """The base is faster than it is told, as one that takes no notice of a throttle.

    Args:
        times: as fast as told.
    """

    def __init__(self, times: float) -> None:
        self._times = times

    def command(self, command: Command) -> Command:
        """The command of a faster base; the arm's part of it is as told."""
        return replace(command, base_twist=self._times * command.base_twist)


class SendingFails(Effect):
    """Commanding the robot raises an exception; nothing reaches it.

    Args:
        error: makes it.
    """

    def __init__(self, error: Callable[[], Exception]) -> None:
        self._error = error

    def command(self, command: Command) -> Command:
        """Never returns."""
        raise self._error()


class GripperDead(Effect):
    """The fingers do not move, and say nothing."""

    def grip(self, width: float) -> float | None:
        """None."""
        return None


class GripperHalfway(Effect):
    """The fingers stop in the middle of their way."""

    def grip(self, width: float) -> float | None:
        """The middle."""
        return (width + self.site.state.gripper_width) / 2.0
