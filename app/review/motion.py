"""The motion of a finished run, sample by sample: what moved, and what limited it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt

from app.core import COMMANDS, OPTIONS, STATES
from app.review.event_log import DamagedRunError
from config import UserError
from controller import RobotModel
from robots import RobotDescription, at_pace, load_robot, with_base_speeds

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_STILL_BASE, _STILL_ARM = 0.01, 0.02
"""Slower than this base [m/s and rad/s] and arm [rad/s] stand still."""
_AT_LIMIT = 0.95
"""From this share on a speed, or an acceleration, is at its limit."""
_FINGERS = 1e-5
"""Fingers that change their distance by more than this in a sample move [m]."""


class Reason(StrEnum):
    """What a sample is limited by; the first that applies counts."""

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
    """What a run has recorded of its motion, in K samples."""

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
        """(K,) how long each sample lasts [s]."""
        return np.append(np.diff(self.times), 0.0)

    @cached_property
    def base_moves(self) -> Mask:
        """(K,)."""
        moves: Mask = np.abs(self.twist).max(axis=1) > _STILL_BASE
        return moves

    @cached_property
    def arm_moves(self) -> Mask:
        """(K,)."""
        moves: Mask = np.abs(self.qd).max(axis=1) > _STILL_ARM
        return moves

    @cached_property
    def stationary(self) -> Mask:
        """(K,) whether neither base nor arm moves."""
        return ~(self.base_moves | self.arm_moves)

    @cached_property
    def tool(self) -> Array:
        """(K, 3) where the end effector is in the world [m]."""
        model = RobotModel(self.robot)
        in_base = np.array([model.bTe(q).translation for q in self.q]).reshape(-1, 3)
        x, y, heading = self.base.T
        c, s = np.cos(heading), np.sin(heading)
        forward, left, up = in_base.T
        return np.stack([x + c * forward - s * left, y + s * forward + c * left, up], axis=1)

    @property
    def distance(self) -> float:
        """That the base has driven [m]."""
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
        """(K,) the samples of a time."""
        inside: Mask = (self.times >= begin) & (self.times < end)
        return inside


def read_motion(folder: Path) -> RunMotion:
    """The motion of a finished run.

    Raises:
        DamagedRunError: it cannot be read, or there is none.
    """
    try:
        states, commands = np.load(folder / STATES), np.load(folder / COMMANDS)
        options = json.loads((folder / OPTIONS).read_text(encoding="utf-8"))
        described = with_base_speeds(
            load_robot(str(options["robot"])),
            options.get("base_speed"),
            options.get("reverse_speed"),
        )
        robot = at_pace(described, float(options.get("pace", 1.0)))
        good = states.ndim == commands.ndim == 2 and states.shape[1] == 22
        if not good or commands.shape[1] != 11 or min(len(states), len(commands)) < 2:
            raise ValueError("nothing moved in this run")
    except UserError:
        raise
    except (OSError, EOFError, ValueError, LookupError, TypeError, AttributeError) as error:
        text = f"{folder}: the motion of this run cannot be read: {error}"
        raise DamagedRunError(text) from error
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
