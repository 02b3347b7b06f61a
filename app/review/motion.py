"""Motion of a finished run: samples, what limited them, and delays of the axes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

from app.core import COMMANDS, OPTIONS, STATES
from app.review.event_log import DamagedRunError
from controller import RobotModel
from robots import RobotDescription, at_pace, load_robot, with_base_speeds

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_STILL_BASE, _STILL_ARM = 0.01, 0.02
"""Slower than this base [m/s and rad/s] and arm [rad/s] stand still."""
_AT_LIMIT = 0.95
_FINGERS = 1e-5
"""Larger changes of the gripper width within a sample count as motion [m]."""


class Reason(StrEnum):
    """What limits a sample; the first that applies counts."""

    FINGERS = "still: fingers move"
    WAITS = "still: looks, thinks or rests"
    REVERSE = "base: reverse speed"
    DRIVE = "base: speed"
    TURN = "base: turn rate"
    JOINT = "arm: joint speed"
    BASE_ACCELERATION = "base: acceleration"
    JOINT_ACCELERATION = "arm: acceleration"
    CHOICE = "no limit: speed asked for, or steering"


@dataclass(frozen=True, kw_only=True, eq=False)
class RunMotion:
    """Recorded motion of a run, in K samples."""

    robot: RobotDescription
    times: Array
    """(K,) on the session's clock [s]."""
    base: Array
    """(K, 3) x, y [m] and heading [rad]."""
    twist: Array
    """(K, 3) of the base, in its frame [m/s, m/s, rad/s]."""
    q: Array
    """(K, 7) [rad]."""
    qd: Array
    """(K, 7) [rad/s]."""
    width: Array
    """(K,) between the fingers [m]."""
    commands: Array
    """(K, 10) twist of the base, then joint velocities."""

    @cached_property
    def steps(self) -> Array:
        """(K,) durations of the samples [s]."""
        return np.append(np.diff(self.times), 0.0)

    @cached_property
    def base_moves(self) -> Mask:
        """(K,) whether the base moves."""
        moves: Mask = np.abs(self.twist).max(axis=1) > _STILL_BASE
        return moves

    @cached_property
    def arm_moves(self) -> Mask:
        """(K,) whether the arm moves."""
        moves: Mask = np.abs(self.qd).max(axis=1) > _STILL_ARM
        return moves

    @cached_property
    def stationary(self) -> Mask:
        """(K,) whether neither base nor arm moves."""
        return ~(self.base_moves | self.arm_moves)

    @cached_property
    def tool(self) -> Array:
        """(K, 3) position of the end effector in the world [m]."""
        model = RobotModel(self.robot)
        in_base = np.array([model.bTe(q).translation for q in self.q]).reshape(-1, 3)
        x, y, heading = self.base.T
        c, s = np.cos(heading), np.sin(heading)
        forward, left, up = in_base.T
        return np.stack([x + c * forward - s * left, y + s * forward + c * left, up], axis=1)

    @property
    def distance(self) -> float:
        """Distance that the base has driven [m]."""
        return float(np.hypot(self.twist[:, 0], self.twist[:, 1]) @ self.steps)

    @cached_property
    def reasons(self) -> npt.NDArray[np.int64]:
        """(K,) the number of the `Reason` of each sample."""
        limits, still = self.robot.limits, self.stationary
        vx, speed = self.twist[:, 0], np.hypot(self.twist[:, 0], self.twist[:, 1])
        change = np.abs(np.diff(self.commands, axis=0, prepend=self.commands[:1]))
        rates = change / np.maximum(self.steps, 1e-3)[:, None]
        base_rates = rates[:, :3] >= _AT_LIMIT * limits.base_acceleration
        tests = {
            Reason.FINGERS: still
            & (np.abs(np.diff(self.width, prepend=self.width[:1])) > _FINGERS),
            Reason.WAITS: still,
            Reason.REVERSE: vx <= -_AT_LIMIT * limits.base_reverse,
            Reason.DRIVE: speed >= _AT_LIMIT * limits.base_twist[0],
            Reason.TURN: np.abs(self.twist[:, 2]) >= _AT_LIMIT * limits.base_twist[2],
            Reason.JOINT: (np.abs(self.qd) >= _AT_LIMIT * limits.qd).any(axis=1),
            Reason.BASE_ACCELERATION: base_rates[:, 0] | base_rates[:, 2],
            Reason.JOINT_ACCELERATION: (rates[:, 3:] >= _AT_LIMIT * limits.qdd).any(axis=1),
        }
        order = [list(Reason).index(reason) for reason in tests]
        chosen = np.select(list(tests.values()), order, default=list(Reason).index(Reason.CHOICE))
        return chosen.astype(np.int64)

    def between(self, begin: float, end: float) -> Mask:
        """(K,) the samples from `begin` to `end` [s]."""
        inside: Mask = (self.times >= begin) & (self.times < end)
        return inside


def read_motion(folder: Path) -> RunMotion:
    """The motion of a finished run.

    Raises:
        DamagedRunError: it cannot be read, or there is none.
    """
    states, commands = _arrays(folder)
    try:
        options = json.loads((folder / OPTIONS).read_text(encoding="utf-8"))
        speeds = options.get("base_speed"), options.get("reverse_speed")
        described = with_base_speeds(load_robot(str(options["robot"])), *speeds)
        robot = at_pace(described, float(options.get("pace", 1.0)))
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise _damaged(folder, error) from error
    sent = np.clip(np.searchsorted(commands[:, 0], states[:, 0]), 0, len(commands) - 1)
    return RunMotion(
        robot=robot,
        times=states[:, 0],
        base=states[:, 1:4],
        twist=states[:, 4:7],
        q=states[:, 7:14],
        qd=states[:, 14:21],
        width=states[:, 21],
        commands=commands[sent, 1:],
    )


def _arrays(folder: Path) -> tuple[Array, Array]:
    """States and commands of a run; raises DamagedRunError if they cannot be read."""
    try:
        states, commands = np.load(folder / STATES), np.load(folder / COMMANDS)
        if states.ndim != 2 or states.shape[1] != 22 or commands.shape[1] != 11:
            raise ValueError("no run writes such arrays")
    except (OSError, EOFError, ValueError, IndexError, AttributeError) as error:
        raise _damaged(folder, error) from error
    if min(len(states), len(commands)) < 2:
        raise _damaged(folder, "nothing moved in it")
    return states, commands


def _damaged(folder: Path, why: object) -> DamagedRunError:
    return DamagedRunError(f"{folder}: the motion of this run cannot be read: {why}")


_STEP = 0.005
"""Step of the time grid [s]."""
_LONGEST = 120.0
"""Longest evaluated part of a run [s]."""
_GAP = 0.1
"""Longest interval between readings that is interpolated [s]."""
_LEAST = 0.02
"""Smallest rms command that is evaluated [m/s or rad/s]."""
_DEAD = np.arange(0.0, 0.31, 0.01)
_LAGS = np.array([0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15, 0.18, 0.22, 0.27, 0.33, 0.4])
_AXES = {"base, driving": (1, 4), "base, turning": (3, 6)} | {
    f"joint {number}": (3 + number, 13 + number) for number in range(1, 8)
}


class Delay(NamedTuple):
    """Delay of one axis: a dead time, then a first-order lag."""

    axis: str
    dead: float
    """Dead time [s]."""
    lag: float
    """Time constant [s]."""
    error: float
    """Rms error of the model, as a share of the rms command."""

    @property
    def total(self) -> float:
        """The lag in the sense of a robot description [s]."""
        return self.dead + self.lag

    def __str__(self) -> str:
        dead, lag = 1000.0 * self.dead, 1000.0 * self.lag
        return f"{self.axis}: {dead:.0f} ms and a lag of {lag:.0f} ms ({100.0 * self.error:.0f} %)"


def delays(folder: Path) -> list[Delay]:
    """The delays of the axes that moved in a run.

    Raises:
        DamagedRunError: there are none, or the run is not complete.
    """
    states, commands = _arrays(folder)
    begin, end = commands[0, 0], min(commands[-1, 0], commands[0, 0] + _LONGEST)
    grid = np.arange(begin, end, _STEP)
    after = np.clip(np.searchsorted(states[:, 0], grid), 1, len(states) - 1)
    known = states[after, 0] - states[after - 1, 0] < _GAP
    found = []
    for axis, (column, measured) in _AXES.items():
        command = np.interp(grid, commands[:, 0], commands[:, column])
        if float(np.sqrt(np.mean(command**2))) >= _LEAST:
            velocity = np.interp(grid, states[:, 0], states[:, measured])
            found.append(_fit(axis, command, velocity, known))
    if not found:
        raise _damaged(folder, "nothing moved in it")
    return found


def _fit(axis: str, command: Array, velocity: Array, known: Mask) -> Delay:
    tried = []
    for dead, lag in product(_DEAD, _LAGS):
        late = np.concatenate([np.zeros(round(dead / _STEP)), command])[: len(command)]
        share = 1.0 - np.exp(-_STEP / lag)
        followed = lfilter([share], [1.0, share - 1.0], late)
        error = float(np.sqrt(np.mean((followed - velocity)[known] ** 2)))
        tried.append(Delay(axis, float(dead), float(lag), error))
    best = min(tried, key=lambda one: one.error)
    return best._replace(error=best.error / float(np.sqrt(np.mean(command**2))))
