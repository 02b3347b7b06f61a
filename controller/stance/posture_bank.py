"""The posture bank: dexterous arm postures, and the candidates among them for a goal.

A posture suits a goal if its end effector has the goal's height and tilt; the base pose does the
rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import hypot
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Indices
from config.poses import MapPose
from controller.stance.bank_drawing import stored_postures
from controller.stance.tool_poses import ToolPoses, forward_kinematics
from robots import RobotDescription, Swivel

_WINDOWS = ((0.08, 0.96), (0.2, 0.85))
"""Largest differences of height [m] and tilt (a cosine) to the goal's: the first window that holds
enough postures is taken, and among fixtures the next one after it."""
_MIN_CANDIDATES = 12  # least number of postures in a window
_FALLBACK_CANDIDATES = 300  # nearest postures that are taken if every window is too narrow
_NEAREST = 36  # nearest postures that an arm without a choice tries, too
_METRES_PER_TILT = 0.3  # distance equivalent to the cosine of the tilt there [m]
_MAX_FAR = 800  # largest number of postures of the second window
_MAX_TURNED = 160  # largest number of postures of the first window for each turn of the base
_TURNS = (-1.5, -1.0, -0.5, 0.5, 1.0, 1.5)  # turns of the base that bring the hand beside it [rad]
_DOWN = 0.3  # largest `sideways` of a hand that may be beside the base from the start


class PostureBank(NamedTuple):
    """The bank for one robot, sorted by the height of the end effector."""

    q: Array  # (N, j) joint positions [rad]
    tools: ToolPoses
    swivel: Swivel | None


@lru_cache(maxsize=4)
def bank(robot: RobotDescription) -> PostureBank:
    """The stored postures within the joint limits of a robot."""
    q = stored_postures(robot)
    tools = forward_kinematics(robot, q)
    order = np.argsort(tools.positions[:, 2])
    return PostureBank(q[order], ToolPoses(*(values[order] for values in tools)), robot.swivel)


class Candidates(NamedTuple):
    """N postures of the bank with the arm turned."""

    indices: Indices  # (N,) in the bank
    turns: Array  # (N,) about its swivel [rad]; the base turns the other way


def candidates(
    bank: PostureBank,
    mTe: MapPose,
    *,
    among_fixtures: bool = False,
    has_choice: bool = True,
) -> Iterator[Candidates]:
    """The postures with about the height and tilt of a pose, the likely ones first.

    Where the end effector points down, some of them come again with the base turned below the arm.
    Among fixtures the postures of the next window follow, and those. For an arm without a choice
    the nearest follow: limits and contact keep it from most postures that are not quite there.
    """
    heights, verticals = bank.tools.positions[:, 2], bank.tools.rotations[:, 2]
    height, vertical = mTe.translation[2], mTe.rotation[2]
    windows: list[Indices] = []
    for window, min_cosine in _WINDOWS:
        first, last = np.searchsorted(heights, [height - window, height + window])
        found = first + np.flatnonzero(verticals[first:last] @ vertical > min_cosine)
        if len(found) >= _MIN_CANDIDATES:
            windows.append(found)
    if not windows:
        windows.append(nearest(bank, mTe, _FALLBACK_CANDIDATES))
    near = windows[0]
    some = near[:: 1 + len(near) // _MAX_TURNED] if bank.swivel else near[:0]
    turned = Candidates(np.tile(some, len(_TURNS)), np.repeat(_TURNS, len(some)))
    straight = Candidates(near, np.zeros(len(near)))
    yield _both(straight, turned) if sideways(mTe) < _DOWN else straight
    if not has_choice:
        yield Candidates(nearest(bank, mTe, _NEAREST), np.zeros(_NEAREST))
    if among_fixtures:
        far = windows[1][:: 1 + len(windows[1]) // _MAX_FAR] if len(windows) > 1 else near[:0]
        yield _both(Candidates(far, np.zeros(len(far))), turned)


def nearest(bank: PostureBank, mTe: MapPose, count: int) -> Indices:
    """Indices (count,) of the postures nearest to height and tilt of a pose."""
    heights, verticals = bank.tools.positions[:, 2], bank.tools.rotations[:, 2]
    away = np.abs(heights - mTe.translation[2])
    distance = away - _METRES_PER_TILT * (verticals @ mTe.rotation[2])
    return np.argpartition(distance, count)[:count]


def sideways(mTe: MapPose) -> float:
    """0 for an end effector that points straight up or down, 1 for a horizontal one."""
    return hypot(*mTe.rotation[:2, 2].tolist())


def _both(one: Candidates, other: Candidates) -> Candidates:
    return Candidates(*(np.concatenate(pair) for pair in zip(one, other, strict=True)))
