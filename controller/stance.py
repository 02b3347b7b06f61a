"""Choosing a stance for a goal: the posture of the arm, and with it the pose of the base."""

from __future__ import annotations

from math import atan2, cos, pi, sin
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.base_drive import Pose2D
from controller.command import Array
from controller.model import RobotModel
from controller.postures import Bank, ToolPoses, forward_kinematics
from controller.self_collision import SelfCollision
from controller.settings import StanceSettings

Indices: TypeAlias = npt.NDArray[np.int64]

_WINDOWS = ((0.08, 0.96), (0.2, 0.85))
"""How far the height [m] and tilt (a cosine) of a posture may be from the goal's before refinement:
the first window that holds enough postures is taken."""
_MIN_CANDIDATES = 12
"""A window with fewer postures than this is too narrow."""
_FALLBACK_CANDIDATES = 300
"""Nearest postures that are ranked where every window is too narrow."""
_METRES_PER_TILT = 0.3
"""What the cosine of the tilt counts like in that search [m]."""

_BATCH = 12
"""Postures that are refined at once, the best first."""
_MAX_BATCHES = 3
"""Batches that are refined before the best posture so far is taken, good enough or not."""
_ITERATIONS = 5
"""Of the refinement, which converges quadratically."""
_TOLERANCE = 1e-3
"""Sum of the errors of height and tilt of a posture that suits the goal [m + rad]."""
_MAX_ERROR = 0.5
"""Larger errors are cut to this in an iteration, as the equations are linearised [m and rad]."""
_DAMPING = 1e-4
"""Of the least squares, small against J Jᵀ of a regular posture [m² and rad²]."""
_MIN_SINE = 1e-9
"""Keeps a tilt error of zero from being divided by zero."""

_PATH_SAMPLES = np.linspace(0.0, 1.0, 17)[1:, None]
"""Where the straight path to a posture is checked for contact."""


class Stance(NamedTuple):
    """How to stand for a goal."""

    q: Array
    """(7,) posture of the arm [rad]."""
    bTe: SE3
    """End effector in the base, for that posture."""
    reverse: bool
    """Whether the base drives there backwards."""

    def base_for(self, wTe: SE3) -> Pose2D:
        """The base pose that brings the end effector to `wTe`.

        The heading is the turn about the vertical that brings the end effector's rotation in the
        base nearest to the goal's.
        """
        (a, b, c), (d, e, f), _ = self.bTe.rotation.tolist()
        (g, h, i), (j, k, m), _ = wTe.rotation.tolist()
        along = a * g + b * h + c * i + d * j + e * k + f * m
        across = a * j + b * k + c * m - d * g - e * h - f * i
        heading = atan2(across, along)
        cosine, sine = cos(heading), sin(heading)
        x, y, _ = self.bTe.translation.tolist()
        wx, wy, _ = wTe.translation.tolist()
        return Pose2D(wx - (cosine * x - sine * y), wy - (sine * x + cosine * y), heading)


def choose_stance(
    model: RobotModel,
    settings: StanceSettings,
    bank: Bank,
    collision: SelfCollision,
    wTe: SE3,
    wTb: Pose2D,
    q: Array,
    failed: tuple[Stance, ...] = (),
) -> Stance:
    """The stance that reaches a pose soonest, among those that are dexterous and in front.

    The bank's postures near the goal's height and tilt are ranked, the best are refined until they
    have exactly that height and tilt, and the best of those whose straight path in joint space is
    clear of contact is taken. If none is found in a few batches, the least bad one is.

    Args:
        model: the robot.
        settings: what a stance costs.
        bank: the postures to choose from.
        collision: the robot's shapes.
        wTe: the pose to reach.
        wTb: base pose.
        q: (7,) joint positions [rad].
        failed: stances that stalled before this goal; another one is preferred.
    """
    candidates = _candidates(bank, wTe)
    tools = ToolPoses(*(values[candidates] for values in bank.tools))
    costs = _costs(model, settings, wTe, wTb, q, bank.q[candidates], tools)[0]
    ranked = candidates[np.argsort(costs)]
    best: tuple[float, Stance] | None = None
    for number in range(_MAX_BATCHES):
        batch = ranked[number * _BATCH : (number + 1) * _BATCH]
        if len(batch) == 0:
            break
        postures, error = _refine(model, settings, wTe, bank.q[batch])
        tools = forward_kinematics(model.description, postures)
        costs, reverse = _costs(model, settings, wTe, wTb, q, postures, tools)
        unreached = settings.unreached_cost
        costs = costs + np.where(error > _TOLERANCE, unreached + unreached * error, 0.0)
        for stance in failed:
            same = np.abs(postures - stance.q).max(axis=1) < settings.joint_difference
            costs = costs + np.where(same, settings.failed_cost, 0.0)
        for one in np.argsort(costs):
            cost = float(costs[one])
            if best is not None and cost >= best[0]:
                break
            missing = settings.clearance - _path_clearance(collision, q, postures[one])
            cost += settings.contact_cost * max(0.0, missing)
            if best is None or cost < best[0]:
                bTe = SE3(tools.rotations[one], tools.positions[one])
                best = cost, Stance(postures[one], bTe, bool(reverse[one]))
        if best is not None and best[0] < settings.failed_cost:
            break
    assert best is not None
    return best[1]


def _candidates(bank: Bank, wTe: SE3) -> Indices:
    """Indices of the postures whose end effector is about as high and as tilted as the goal."""
    heights, verticals = bank.tools.positions[:, 2], bank.tools.rotations[:, 2]
    height, vertical = wTe.translation[2], wTe.rotation[2]
    for window, min_cosine in _WINDOWS:
        first, last = np.searchsorted(heights, [height - window, height + window])
        found: Indices = first + np.flatnonzero(verticals[first:last] @ vertical > min_cosine)
        if len(found) >= _MIN_CANDIDATES:
            return found
    distance = np.abs(heights - height) - _METRES_PER_TILT * (verticals @ vertical)
    nearest: Indices = np.argpartition(distance, _FALLBACK_CANDIDATES)[:_FALLBACK_CANDIDATES]
    return nearest


def _base_poses(wTe: SE3, tools: ToolPoses) -> Array:
    """x, y, heading (N, 3) of the bases that bring their end effectors to `wTe`."""
    R, p = wTe.rotation, wTe.translation
    positions, rotations = tools.positions, tools.rotations
    c = rotations[:, 0] @ R[0] + rotations[:, 1] @ R[1]
    s = rotations[:, 0] @ R[1] - rotations[:, 1] @ R[0]
    heading = np.arctan2(s, c)
    c, s = np.cos(heading), np.sin(heading)
    x, y = positions[:, 0], positions[:, 1]
    return np.stack([p[0] - (c * x - s * y), p[1] - (s * x + c * y), heading], axis=1)


def _costs(
    model: RobotModel,
    settings: StanceSettings,
    wTe: SE3,
    wTb: Pose2D,
    q: Array,
    postures: Array,
    tools: ToolPoses,
) -> tuple[Array, Array]:
    """Costs (N,) of postures [s], and whether the base drives there backwards (N,)."""
    limits, s = model.limits, settings
    driving, reverse = _driving_times(model, settings, wTb, _base_poses(wTe, tools))
    folding = (np.abs(postures - q) / (s.arm_speed * limits.qd)).max(axis=1)
    margin = np.minimum(postures - limits.q_min, limits.q_max - postures).min(axis=1)
    bearing = np.abs(np.arctan2(tools.positions[:, 1], tools.positions[:, 0]))
    costs = (
        np.maximum(driving, folding)
        + s.overlap * np.minimum(driving, folding)
        + s.manipulability_cost * np.maximum(0.0, s.min_manipulability - tools.manipulability)
        + s.bearing_cost * bearing
        + s.limit_cost * np.maximum(0.0, s.preferred_limit_margin - margin)
    )
    return costs, reverse


def _driving_times(
    model: RobotModel, settings: StanceSettings, wTb: Pose2D, bases: Array
) -> tuple[Array, Array]:
    """Expected times (N,) to drive to base poses (N, 3) [s], and whether backwards is faster."""
    forward, turn_rate = model.limits.base_twist[0], model.limits.base_twist[2]
    backward = model.limits.base_reverse
    dx, dy = bases[:, 0] - wTb.x, bases[:, 1] - wTb.y
    distance, turn = np.hypot(dx, dy), _wrap(bases[:, 2] - wTb.heading)
    bearing = _wrap(np.arctan2(dy, dx) - wTb.heading)
    if model.n_base == 3:
        # Only the component along -x has the reverse speed.
        share = np.maximum(-np.cos(bearing), backward / forward)
        speed = np.minimum(forward, backward / share)
        return np.maximum(distance / speed, np.abs(turn) / turn_rate), np.zeros(len(bases), bool)
    back = _wrap(bearing + pi)
    ahead_turns = (np.abs(bearing) + np.abs(_wrap(turn - bearing))) / turn_rate
    back_turns = (np.abs(back) + np.abs(_wrap(turn - back))) / turn_rate + settings.reverse_cost
    ahead = distance / forward + settings.turn_weight * ahead_turns
    behind = distance / backward + settings.turn_weight * back_turns
    return np.minimum(ahead, behind), behind < ahead


def _wrap(angles: Array) -> Array:
    wrapped: Array = (angles + pi) % (2.0 * pi) - pi
    return wrapped


def _refine(model: RobotModel, settings: StanceSettings, wTe: SE3, q: Array) -> tuple[Array, Array]:
    """Move postures (N, 7) until their end effectors have the height and tilt of the goal.

    Damped least squares on three equations: height, and the two angles of the vertical as the end
    effector sees it. The first joint changes neither and stays. Joints that come near a limit stay
    there.

    Returns:
        Postures (N, 7), and the sum of the remaining errors of each (N,) [m + rad].
    """
    low = model.limits.q_min + settings.limit_margin
    high = model.limits.q_max - settings.limit_margin
    height, vertical = wTe.translation[2], wTe.rotation[2]
    for _ in range(_ITERATIONS):
        tools = forward_kinematics(model.description, q)
        seen = tools.rotations @ vertical  # the goal's vertical; (0, 0, 1) where the tilt is right
        sine = np.hypot(seen[:, 0], seen[:, 1])
        scale = np.arctan2(sine, seen[:, 2]) / np.maximum(sine, _MIN_SINE)
        errors = np.stack(
            [height - tools.positions[:, 2], seen[:, 1] * scale, -seen[:, 0] * scale], axis=1
        )
        total: Array = np.abs(errors).sum(axis=1)
        if (total < _TOLERANCE).all():
            break
        J = tools.J[:, [2, 3, 4]]
        J[:, :, 0] = 0.0
        errors = np.clip(errors, -_MAX_ERROR, _MAX_ERROR)
        step = _damped_least_squares(J, errors)
        blocked = (q + step < low) | (q + step > high)
        step = _damped_least_squares(np.where(blocked[:, None, :], 0.0, J), errors)
        q = np.clip(q + step, low, high)
    return q, total


def _damped_least_squares(J: Array, errors: Array) -> Array:
    """Steps (N, 7) for Jacobians (N, 3, 7) and errors (N, 3)."""
    JT = np.swapaxes(J, 1, 2)
    squares = J @ JT + _DAMPING * np.eye(3)
    return (JT @ np.linalg.solve(squares, errors[:, :, None]))[:, :, 0]


def _path_clearance(collision: SelfCollision, q: Array, target: Array) -> float:
    """Smallest clearance on the straight path from one posture to another [m]."""
    return min(collision.clearance(posture) for posture in q + _PATH_SAMPLES * (target - q))
