"""The posture bank: dexterous arm postures, and the candidates among them for a goal.

A posture suits a goal if its end effector has the goal's height and tilt; the base pose does the
rest. The bank was drawn at random from dexterous postures within the joint limits and without
self-collision; it comes with the package.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from math import hypot
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.collision.self_collision import SelfCollision
from controller.command import Array
from controller.floor.base_drive import wrap
from controller.model import RobotModel
from robots import RobotDescription, Swivel, load_robot, robot_names

BANK = Path(__file__).with_name("postures.npy")
"""The stored bank: (60 000, 7) joint positions in half precision [rad], from `draw` with `SEED`."""
SEED = 20220101

# The stored bank must be drawn again when one of these changes.
_LIMIT_MARGIN = 0.2  # least distance to every joint limit [rad]
_MIN_MANIPULABILITY = 0.035
_MAX_BEARING = 0.3  # largest |θ_ε|, the bearing of the end effector seen from the arm's foot [rad]
_MIN_REACH = 0.25  # least horizontal distance of the end effector from the arm's foot [m]
_CLEARANCE = 0.03  # least distance from the robot itself and the floor [m]
_DRAWN_AT_ONCE = 4096

# The choice of candidates.
_WINDOWS = ((0.08, 0.96), (0.2, 0.85))
"""Largest differences of height [m] and tilt (a cosine) to the goal's: the first window that holds
enough postures is taken, and among fixtures the next one after it."""
_MIN_CANDIDATES = 12  # least number of postures in a window
_FALLBACK_CANDIDATES = 300  # nearest postures that are taken if every window is too narrow
_METRES_PER_TILT = 0.3  # distance equivalent to the cosine of the tilt there [m]
_MAX_FAR = 800  # largest number of postures of the second window
_MAX_TURNED = 160  # largest number of postures of the first window for each turn of the base
_TURNS = (-1.5, -1.0, -0.5, 0.5, 1.0, 1.5)  # turns of the base that bring the hand beside it [rad]
_DOWN = 0.3  # largest `sideways` of a hand that may be beside the base from the start


class ToolPoses(NamedTuple):
    """The end effector in the base frame, in each of N postures."""

    positions: Array  # (N, 3) [m]
    rotations: Array  # (N, 3, 3)
    J: Array  # (N, 6, 7) Jacobians at the end effector, linear first, in base axes

    @property
    def manipulability(self) -> Array:
        """(N,) Yoshikawa's measure."""
        J = self.J
        squared: Array = np.linalg.det(J @ np.swapaxes(J, 1, 2))
        return np.sqrt(np.maximum(squared, 0.0))

    def turned(self, swivel: Swivel, turns: Array) -> ToolPoses:
        """The same with the arm turned by (N,) angles about its swivel [rad]; J is not turned."""
        c, s, zero = np.cos(turns), np.sin(turns), np.zeros(len(turns))
        R = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1.0], axis=1).reshape(-1, 3, 3)
        pivot = swivel.pivot
        positions = pivot + (R @ (self.positions - pivot)[:, :, None])[:, :, 0]
        return ToolPoses(positions, R @ self.rotations, self.J)


def forward_kinematics(robot: RobotDescription, q: Array) -> ToolPoses:
    """Forward kinematics of many postures (N, j) at once [rad]."""
    bTa, placements, lTe = _transforms(robot)
    j, slides = len(placements), robot.arm.slides
    c, s = np.cos(q), np.sin(q)
    # Each joint on the one before: its placement, turned about its own z or moved along it.
    x, y = placements[:, :, 0], placements[:, :, 1]
    turned = np.empty((len(q), j, 4, 4))
    turned[:] = placements
    turned[..., 0] = x * c[..., None] + y * s[..., None]
    turned[..., 1] = y * c[..., None] - x * s[..., None]
    for slide in np.flatnonzero(slides):
        turned[:, slide] = placements[slide]
        turned[:, slide, :3, 3] += q[:, slide, None] * placements[slide, :3, 2]
    bTj = np.empty_like(turned)
    bTj[:, 0] = bTa @ turned[:, 0]
    for joint in range(1, j):
        np.matmul(bTj[:, joint - 1], turned[:, joint], out=bTj[:, joint])
    bTe = bTj[:, -1] @ lTe
    axes = np.ascontiguousarray(bTj[..., :3, 2].transpose(2, 0, 1))
    arms = bTe[:, :3, 3].T[:, :, None] - bTj[..., :3, 3].transpose(2, 0, 1)
    J = np.empty((len(q), 6, j))
    for row, (i, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        J[:, row] = axes[i] * arms[k] - axes[k] * arms[i]
        J[:, 3 + row] = axes[row]
        J[:, row, slides] = axes[row][:, slides]
        J[:, 3 + row, slides] = 0.0
    return ToolPoses(bTe[:, :3, 3], bTe[:, :3, :3], J)


@lru_cache(maxsize=8)
def _transforms(robot: RobotDescription) -> tuple[Array, Array, Array]:
    """Homogeneous bTa, placements (7, 4, 4) of every joint on the one before it, and lTe."""
    placements = [_clean(placement.homogeneous) for placement in robot.arm.joints]
    lTe = robot.arm.lTh * robot.gripper.hTe
    return robot.bTa.homogeneous, np.array(placements), lTe.homogeneous


def _clean(transform: Array) -> Array:
    """A transform without rounding errors of quarter turns."""
    whole = np.round(transform)
    return np.where(np.abs(transform - whole) < 1e-12, whole, transform)


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


def stored_postures(robot: RobotDescription, every: int = 1) -> Array:
    """Every n-th stored posture, (N, j), within the joint limits of a robot [rad]."""
    q = np.load(BANK)[::every].astype(float)
    q = q[((robot.limits.q_min <= q) & (q <= robot.limits.q_max)).all(axis=1)]
    return np.asarray(q)


def draw(count: int, rng: np.random.Generator) -> Array:
    """Draw (count, j) postures that are good on every shipped robot [rad]."""
    robots = [load_robot(name) for name in robot_names()]
    collisions = [SelfCollision(RobotModel(robot)) for robot in robots]
    on_the_floor, limits = replace(robots[0], bTa=SE3.Identity()), robots[0].limits
    low, high = limits.q_min + _LIMIT_MARGIN, limits.q_max - _LIMIT_MARGIN
    drawn: list[Array] = []
    while len(drawn) < count:
        q = rng.uniform(low, high, size=(_DRAWN_AT_ONCE, len(low)))
        q[:, 0] = 0.0
        tools = forward_kinematics(on_the_floor, q)
        x, y = tools.positions[:, 0], tools.positions[:, 1]
        q[:, 0] = rng.uniform(-_MAX_BEARING, _MAX_BEARING, len(q)) - np.arctan2(y, x)
        q[:, 0] = wrap(q[:, 0])
        good = (
            (tools.manipulability > _MIN_MANIPULABILITY)
            & (np.hypot(x, y) > _MIN_REACH)
            & (np.abs(q[:, 0]) < high[0])
        )
        drawn += [p for p in q[good] if all(c.clearance(p) > _CLEARANCE for c in collisions)]
    return np.array(drawn[:count])


class Candidates(NamedTuple):
    """N postures of the bank with the arm turned."""

    indices: npt.NDArray[np.int64]  # (N,) in the bank
    turns: Array  # (N,) about its swivel [rad]; the base turns the other way


def candidates(
    bank: PostureBank, wTe: SE3, *, among_fixtures: bool = False
) -> Iterator[Candidates]:
    """The postures with about the height and tilt of a pose, the likely ones first.

    Where the end effector points down, some of them come again with the base turned below the arm.
    Among fixtures the postures of the next window follow, and those.
    """
    heights, verticals = bank.tools.positions[:, 2], bank.tools.rotations[:, 2]
    height, vertical = wTe.translation[2], wTe.rotation[2]
    windows: list[npt.NDArray[np.int64]] = []
    for window, min_cosine in _WINDOWS:
        first, last = np.searchsorted(heights, [height - window, height + window])
        found = first + np.flatnonzero(verticals[first:last] @ vertical > min_cosine)
        if len(found) >= _MIN_CANDIDATES:
            windows.append(found)
    if not windows:
        windows.append(nearest(bank, wTe, _FALLBACK_CANDIDATES))
    near = windows[0]
    some = near[:: 1 + len(near) // _MAX_TURNED] if bank.swivel else near[:0]
    turned = Candidates(np.tile(some, len(_TURNS)), np.repeat(_TURNS, len(some)))
    straight = Candidates(near, np.zeros(len(near)))
    yield _both(straight, turned) if sideways(wTe) < _DOWN else straight
    if among_fixtures:
        far = windows[1][:: 1 + len(windows[1]) // _MAX_FAR] if len(windows) > 1 else near[:0]
        yield _both(Candidates(far, np.zeros(len(far))), turned)


def nearest(bank: PostureBank, wTe: SE3, count: int) -> npt.NDArray[np.int64]:
    """Indices (count,) of the postures nearest to height and tilt of a pose."""
    heights, verticals = bank.tools.positions[:, 2], bank.tools.rotations[:, 2]
    away = np.abs(heights - wTe.translation[2])
    distance = away - _METRES_PER_TILT * (verticals @ wTe.rotation[2])
    return np.argpartition(distance, count)[:count]


def sideways(wTe: SE3) -> float:
    """0 for an end effector that points straight up or down, 1 for a horizontal one."""
    return hypot(*wTe.rotation[:2, 2].tolist())


def _both(one: Candidates, other: Candidates) -> Candidates:
    return Candidates(*(np.concatenate(pair) for pair in zip(one, other, strict=True)))
