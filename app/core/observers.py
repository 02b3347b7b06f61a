"""Observers of a run (recording, log, page, terminal) and instruments of benches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from hw import Robot

if TYPE_CHECKING:
    from app.core.session import Tick
    from app.core.setup import Setup
    from trees.language import TreeNode


class Observers:
    """Calls observers; one that raises is reported and not called again, and the run goes on."""

    def __init__(self) -> None:
        self._failed: dict[str, str] = {}

    def tell(self, name: str, call: Callable[[], object]) -> None:
        """Call an observer by its name for people, unless it has failed before."""
        if name in self._failed:
            return
        try:
            call()
        except BaseException as error:  # whatever it is, the robot must go on
            self._failed[name] = f"{name} ended early ({type(error).__name__}: {error})"

    @property
    def failures(self) -> tuple[str, ...]:
        """One text for each observer that failed."""
        return tuple(self._failed.values())


class Instruments:
    """Hooks of a bench into a run, to measure or disturb it; these do nothing."""

    def beneath(self, robot: Robot) -> Robot:
        """A robot in place of the one that faults are injected into."""
        return robot

    def begin(self, setup: Setup, nodes: Sequence[TreeNode]) -> None:
        """Called before the first tick, when the robot is connected."""

    def after(self, tick: Tick) -> None:
        """Called after every tick."""
