"""Delays of the axes of a robot in a finished run."""

from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from app.review import DamagedRunError, read_motion
from config.arrays import Array, Mask

_STEP = 0.005  # step of the time grid [s]
_LONGEST = 120.0  # longest evaluated part of a run [s]
_GAP = 0.1  # longest interval between readings that is interpolated [s]
_LEAST = 0.02  # smallest rms command that is evaluated [m/s or rad/s]
_DEAD = np.arange(0.0, 0.31, 0.01)
_LAGS = np.array([0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15, 0.18, 0.22, 0.27, 0.33, 0.4])


class Delay(NamedTuple):
    """Delay of one axis: a dead time, then a first-order lag."""

    axis: str
    dead: float  # dead time [s]
    lag: float  # time constant [s]
    error: float  # rms error of the model, as a share of the rms command

    @property
    def total(self) -> float:
        """The lag in the sense of a robot description [s]."""
        return self.dead + self.lag

    def __str__(self) -> str:
        dead, lag = 1000.0 * self.dead, 1000.0 * self.lag
        return f"{self.axis}: {dead:.0f} ms and a lag of {lag:.0f} ms ({100.0 * self.error:.0f} %)"


def delays(folder: Path) -> list[Delay]:
    """The delays of the axes that moved in a run.

    Raises DamagedRunError: there are none, or the run is not complete.
    """
    states, commands = read_motion(folder)
    nothing = DamagedRunError(f"{folder}: nothing moved in this run; name another")
    if min(len(states), len(commands)) < 2:
        raise nothing
    begin, end = commands[0, 0], min(commands[-1, 0], commands[0, 0] + _LONGEST)
    grid = np.arange(begin, end, _STEP)
    after = np.clip(np.searchsorted(states[:, 0], grid), 1, len(states) - 1)
    known = states[after, 0] - states[after - 1, 0] < _GAP
    j = commands.shape[1] - 4
    axes = {"base, driving": (1, 4), "base, turning": (3, 6)} | {
        f"joint {number}": (3 + number, 6 + j + number) for number in range(1, j + 1)
    }
    found = []
    for axis, (column, measured) in axes.items():
        command = np.interp(grid, commands[:, 0], commands[:, column])
        if float(np.sqrt(np.mean(command**2))) >= _LEAST:
            velocity = np.interp(grid, states[:, 0], states[:, measured])
            found.append(_fit(axis, command, velocity, known))
    if not found:
        raise nothing
    return found


def _fit(axis: str, command: Array, velocity: Array, known: Mask) -> Delay:
    from scipy.signal import lfilter  # takes a second, of which other commands have no use

    tried = []
    for dead, lag in product(_DEAD, _LAGS):
        late = np.concatenate([np.zeros(round(dead / _STEP)), command])[: len(command)]
        share = 1.0 - np.exp(-_STEP / lag)
        followed = lfilter([share], [1.0, share - 1.0], late)
        error = float(np.sqrt(np.mean((followed - velocity)[known] ** 2)))
        tried.append(Delay(axis, float(dead), float(lag), error))
    best = min(tried, key=lambda one: one.error)
    return best._replace(error=best.error / float(np.sqrt(np.mean(command**2))))
