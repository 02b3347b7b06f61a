"""How late a robot followed its commands in a run: what `base_lag` and `arm_lag` should say."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from app.core import COMMANDS, STATES
from config import UserError

Array = npt.NDArray[np.float64]

_STEP = 0.005
"""Of the time in which both are compared [s]."""
_LONGEST = 120.0
"""Of a run, from its beginning [s]."""
_GAP = 0.1
"""Longer without a reading, nothing is known of the time between [s]."""
_LEAST = 0.02
"""What was commanded less than this on average tells nothing [m/s or rad/s]."""
_DEAD = np.arange(0.0, 0.31, 0.01)
_LAGS = np.array([0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15, 0.18, 0.22, 0.27, 0.33, 0.4])
_AXES = {"base, driving": (1, 4), "base, turning": (3, 6)} | {
    f"joint {number}": (3 + number, 13 + number) for number in range(1, 8)
}
"""Columns of commands and states."""


class NoMotionError(UserError):
    """A run tells nothing about delays."""


class Delay(NamedTuple):
    """How one axis follows: its command, a time later, through a lag of first order."""

    axis: str
    dead: float
    """[s]"""
    lag: float
    """[s]"""
    error: float
    """Of the measured velocity from that, rms, as a share of the command's rms."""

    @property
    def total(self) -> float:
        """What a description calls the lag [s]."""
        return self.dead + self.lag

    def __str__(self) -> str:
        dead, lag = 1000.0 * self.dead, 1000.0 * self.lag
        return f"{self.axis}: {dead:.0f} ms and a lag of {lag:.0f} ms ({100.0 * self.error:.0f} %)"


def delays(folder: Path) -> list[Delay]:
    """The delays of the axes that moved in a run.

    Raises:
        NoMotionError: there are none, or the run is not complete.
    """
    try:
        commands, states = np.load(folder / COMMANDS), np.load(folder / STATES)
    except (OSError, ValueError, EOFError) as error:
        raise NoMotionError(f"{folder}: the motion of this run cannot be read: {error}") from error
    if min(len(commands), len(states)) < 2:
        raise NoMotionError(f"{folder}: nothing moved in this run")
    begin, end = commands[0, 0], min(commands[-1, 0], commands[0, 0] + _LONGEST)
    grid = np.arange(begin, end, _STEP)
    known = _is_known(states[:, 0], grid)
    found = []
    for axis, (column, measured) in _AXES.items():
        command = np.interp(grid, commands[:, 0], commands[:, column])
        if float(np.sqrt(np.mean(command**2))) >= _LEAST:
            velocity = np.interp(grid, states[:, 0], states[:, measured])
            found.append(_fit(axis, command, velocity, known))
    if not found:
        raise NoMotionError(f"{folder}: nothing moved in this run")
    return found


def _fit(axis: str, command: Array, velocity: Array, known: npt.NDArray[np.bool_]) -> Delay:
    tried = []
    for dead, lag in product(_DEAD, _LAGS):
        late = np.concatenate([np.zeros(round(dead / _STEP)), command])[: len(command)]
        share = 1.0 - np.exp(-_STEP / lag)
        followed = lfilter([share], [1.0, share - 1.0], late)
        error = float(np.sqrt(np.mean((followed - velocity)[known] ** 2)))
        tried.append(Delay(axis, float(dead), float(lag), error))
    best = min(tried, key=lambda one: one.error)
    return best._replace(error=best.error / float(np.sqrt(np.mean(command**2))))


def _is_known(stamps: Array, grid: Array) -> npt.NDArray[np.bool_]:
    """(K,) whether there are readings around a time."""
    after = np.clip(np.searchsorted(stamps, grid), 1, len(stamps) - 1)
    known: npt.NDArray[np.bool_] = stamps[after] - stamps[after - 1] < _GAP
    return known
