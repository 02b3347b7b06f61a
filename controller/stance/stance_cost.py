"""How long the base drives to a stance, and on from there."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from controller.command import Array
from controller.floor import CostField, Pose2D, wrap
from controller.model import RobotModel
from controller.stance_settings import StanceSettings


class Start(NamedTuple):
    """Where the robot sets out from."""

    wTb: Pose2D
    q: Array
    """(7,) joint positions [rad]."""
    way: CostField | None = None
    """What it costs to drive from anywhere to here; None on an open floor."""
    onward: CostField | None = None
    """What it costs to drive from anywhere to the goal after this; None where that is not known."""


def driving_times(
    model: RobotModel, settings: StanceSettings, start: Start, bases: Array
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Expected times (N,) to drive to base poses (N, 3) [s], and whether backwards is faster.

    Infinite where there is no way.
    """
    forward, turn_rate = model.limits.base_twist[0], model.limits.base_twist[2]
    backward, here = model.limits.base_reverse, start.wTb
    dx, dy = bases[:, 0] - here.x, bases[:, 1] - here.y
    straight, turn = np.hypot(dx, dy), wrap(bases[:, 2] - here.heading)
    distance = straight if start.way is None else start.way.at(bases[:, :2])
    bearing = wrap(np.arctan2(dy, dx) - here.heading)
    if model.n_base == 3:
        # Only the component along -x has the reverse speed.
        share = np.maximum(-np.cos(bearing), backward / forward)
        speed = np.minimum(forward, backward / share)
        return np.maximum(distance / speed, np.abs(turn) / turn_rate), np.zeros(len(bases), bool)
    back = wrap(bearing + pi)
    ahead_turns = (np.abs(bearing) + np.abs(wrap(turn - bearing))) / turn_rate
    back_turns = (np.abs(back) + np.abs(wrap(turn - back))) / turn_rate + settings.reverse_cost
    ahead = distance / forward + settings.turn_weight * ahead_turns
    behind = distance / backward + settings.turn_weight * back_turns
    return np.minimum(ahead, behind), behind < ahead


def leaving_times(
    model: RobotModel, settings: StanceSettings, onward: CostField, bases: Array
) -> Array:
    """Expected times (N,) to drive on from base poses (N, 3) [s].

    How the base is turned there is left open.
    """
    forward, _, turn_rate = model.limits.base_twist.tolist()
    distance = onward.at(bases[:, :2])
    ahead: Array = distance / forward
    if model.n_base == 3:
        return ahead
    dx, dy = (onward.ahead_of(bases[:, :2]) - bases[:, :2]).T
    bearing = np.abs(wrap(np.arctan2(dy, dx) - bases[:, 2]))
    ahead = ahead + settings.turn_weight * bearing / turn_rate
    back_turns = (pi - bearing) / turn_rate + settings.reverse_cost
    behind = distance / model.limits.base_reverse + settings.turn_weight * back_turns
    least: Array = np.minimum(ahead, behind)
    return least
