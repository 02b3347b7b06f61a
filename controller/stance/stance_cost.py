"""Costs of stances in seconds: driving times, posture quality, and contact on the way."""

from math import pi
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Mask
from config.planar import Pose2D, wrap
from controller.collision.self_collision import SelfCollision
from controller.floor.cost_field import CostField
from controller.floor.floor_map import FloorMap
from controller.model import RobotModel
from controller.stance.dexterity import dexterity, manipulabilities
from controller.stance.free_space import FreeSpace, se3_of
from controller.stance.stance import Stance
from controller.stance.tool_poses import ToolPoses

_ARM_SPEED = 0.5  # expected share of the joint speed limits
_TURN_WEIGHT = 1.2  # factor of the turning time: curves take longer than turns on the spot
_REVERSE_COST = 0.4  # cost of driving backwards, times `_TURN_WEIGHT` [s]
_OVERLAP = 0.3  # share of the shorter of the times of base and arm that is added to the longer
_MIN_MANIPULABILITY = 0.10  # that of an arm like a Panda below which a posture costs ...
_MANIPULABILITY_COST = 60.0  # ... this much per missing manipulability [s]
_BEARING_COST, _BEARING_COST_DOWN = 4.0, 0.3
"""Cost per |θ_ε| of an end effector that points sideways, which the base carries in, and of one
that points down [s/rad]."""
_POINTING_COST = 2.0
"""Cost per angle between a hand that points sideways and the way ahead, among fixtures: the base
turns beside them, the hand ahead of it [s/rad]."""
_LIMIT_MARGIN = 0.35, 0.12
"""Distance to a joint limit below which a posture costs [rad], as share of a short range ..."""
_LIMIT_COST = 2.0  # cost per missing distance to a joint limit [s/rad]
_SAMPLES = np.linspace(0.0, 1.0, 17)[1:, None]  # shares of the arm's motion that are checked
_IN_CONTACT = 1.0  # more than any way misses [m]
_HERE = (0.3, 0.6)  # shares that are checked at the present place of the base, ...
_THERE = ((0.4, 0.8), (0.4, 1.0), (0.2, 1.0))
"""... and distances before the stance [m] with shares that are checked there."""


class Start(NamedTuple):
    """Where the robot starts from."""

    mTb: Pose2D
    q: Array  # (j,) joint positions [rad]
    floor: FloorMap | None = None  # None on an open floor
    way: CostField | None = None  # cost to drive from anywhere to here; None on an open floor
    next_goal: CostField | None = None  # cost to drive from anywhere to the next goal, if known


def driving_times(model: RobotModel, start: Start, bases: Array) -> tuple[Array, Mask]:
    """Expected times (N,) to drive to base poses (N, 3) [s], and whether backwards is faster.

    Infinite where there is no path.
    """
    forward, turn_rate = model.limits.base_twist[0], model.limits.base_twist[2]
    backward, here = model.limits.base_reverse, start.mTb
    dx, dy = bases[:, 0] - here.x, bases[:, 1] - here.y
    straight, turn = np.hypot(dx, dy), wrap(bases[:, 2] - here.heading)
    distance = straight if start.way is None else start.way.at(bases[:, :2])
    bearing = wrap(np.arctan2(dy, dx) - here.heading)
    if model.n_base == 3:
        # Only the component along -x has the reverse speed.
        share = np.maximum(-np.cos(bearing), backward / forward)
        speed = np.minimum(forward, backward / share)
        return np.maximum(distance / speed, np.abs(turn) / turn_rate), np.zeros(len(bases), bool)
    arrival = bearing if start.way is None else _arrival(start, bases)
    turning = np.abs(bearing) + np.abs(wrap(turn - arrival))
    return _forwards_or_back(model, distance, turning, 2)


def _forwards_or_back(
    model: RobotModel, distance: Array, turning: Array, turns: int
) -> tuple[Array, Mask]:
    """Times (N,) of a differential drive [s], and whether it drives backwards (N,) for that.

    It drives distances (N,) [m] and turns by (N,) [rad] in all; every turn is half a circle less
    that if it drives backwards.
    """
    forward, _, turn_rate = model.limits.base_twist.tolist()
    ahead = distance / forward + _TURN_WEIGHT * turning / turn_rate
    back_turns = (turns * pi - turning) / turn_rate + _REVERSE_COST
    behind = distance / model.limits.base_reverse + _TURN_WEIGHT * back_turns
    return np.minimum(ahead, behind), behind < ahead


def _arrival(start: Start, bases: Array) -> Array:
    """Directions (N,) in which paths arrive at bases (N, 3), from the present heading [rad]."""
    here, places = start.mTb, bases[:, :2]
    assert start.way is not None
    assert start.floor is not None
    straight = start.floor.has_straight_way(here[:2], places)[:, None]
    before = np.where(straight, here[:2], start.way.ahead_of(places))
    dx, dy = (places - before).T
    return wrap(np.arctan2(dy, dx) - here.heading)


def leaving_times(model: RobotModel, next_goal: CostField, bases: Array) -> Array:
    """Expected times (N,) to drive on to the next goal from base poses (N, 3) [s]."""
    distance = next_goal.at(bases[:, :2])
    if model.n_base == 3:
        return distance / float(model.limits.base_twist[0])
    dx, dy = (next_goal.ahead_of(bases[:, :2]) - bases[:, :2]).T
    bearing = np.abs(wrap(np.arctan2(dy, dx) - bases[:, 2]))
    return _forwards_or_back(model, distance, bearing, 1)[0]


def stance_costs(
    model: RobotModel,
    start: Start,
    bases: Array,
    postures: Array,
    tools: ToolPoses,
    sideways: float,
) -> tuple[Array, Mask]:
    """Costs (N,) of postures at base poses (N, 3) [s], and whether to drive backwards (N,).

    `sideways` is 0 for an end effector that points up or down, 1 for a horizontal one.
    """
    limits = model.limits
    driving, reverse = driving_times(model, start, bases)
    folding = (np.abs(postures - start.q) / (_ARM_SPEED * limits.qd)).max(axis=1)
    margins = np.minimum(postures - limits.q_min, limits.q_max - postures)
    dexterous = dexterity(model.description)
    manipulability = manipulabilities(model.description, tools) / dexterous.usual
    lacking = (limits.margins(*_LIMIT_MARGIN) - margins).max(axis=1)
    bearing = np.abs(dexterous.bearing_of(*tools.positions.T[:2]))
    costs = (
        np.maximum(driving, folding)
        + _OVERLAP * np.minimum(driving, folding)
        + _MANIPULABILITY_COST * np.maximum(0.0, _MIN_MANIPULABILITY - manipulability)
        + (_BEARING_COST_DOWN + sideways * (_BEARING_COST - _BEARING_COST_DOWN)) * bearing
        + _LIMIT_COST * np.maximum(0.0, lacking)
    )
    if start.floor is not None:
        pointing = np.abs(dexterous.bearing_of(*tools.rotations[:, :2, 2].T))
        costs += _POINTING_COST * sideways * pointing
    if start.next_goal is not None:
        costs += leaving_times(model, start.next_goal, bases)
    return costs, reverse


def missing_clearance(
    collision: SelfCollision,
    space: FreeSpace | None,
    start: Start,
    base: Pose2D,
    stance: Stance,
    clearance: float,
) -> float:
    """By how much the arm's straight motion in joint space comes nearer than `clearance` [m].

    The sum for the robot itself and for fixtures, of which at most `clearance` counts. A posture
    that touches the robot itself misses `_IN_CONTACT`: it cannot be had.
    """
    way = stance.q - start.q
    clearances = [collision.clearance(posture) for posture in start.q + _SAMPLES * way]
    if clearances[-1] < 0.0:
        return _IN_CONTACT
    missing = max(0.0, clearance - min(clearances))
    if space is None:
        return missing
    here, whole = se3_of(start.mTb), space.arm + space.hand
    now = space.nearest(here, start.q, whole, clearance).distance  # it cannot do better than now
    first = min(space.nearest(here, start.q + k * way, whole, clearance).distance for k in _HERE)
    lacking = max(0.0, now - max(0.0, first))
    forward = -1.0 if stance.reverse else 1.0
    for before, share in _THERE:
        there = se3_of(base.moved(-forward * before))
        near = space.nearest(there, start.q + share * way, whole, clearance)
        lacking = max(lacking, clearance - max(0.0, near.distance))
    return missing + lacking
