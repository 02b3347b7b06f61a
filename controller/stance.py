"""Choosing how to stand for a goal: the posture of the arm, and with it the place of the base."""

from __future__ import annotations

from math import atan2, cos, pi, sin
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller.base_drive import Planar
from controller.command import Array
from controller.model import RobotModel
from controller.postures import Bank, Hands, hands
from controller.self_collision import SelfCollision
from controller.settings import ControllerSettings

Indices: TypeAlias = npt.NDArray[np.int64]

_WINDOWS = ((0.08, 0.96), (0.2, 0.85))
"""How far height [m] and tilt (a cosine) of a posture may be from the goal's before refining."""
_ENOUGH = 12
"""A window with fewer postures than this is too narrow."""
_NEAREST = 300
"""So many postures are looked at where every window is too narrow."""
_REFINED = 12
"""The best so many are refined at once."""
_ROUNDS = 3
"""How often that is tried, with the next best ones, before the best so far has to do."""
_ITERATIONS = 5
_EXACT = 1e-3
"""Sum of what is left of height and tilt in a posture that suits the goal [m + rad]."""
_LIMIT_MARGIN = 0.12
_FAR_FROM_LIMITS = 0.35
_REVERSE_COST = 0.4
_ARM_SPEED = 0.5
"""Share of their speed limits that the joints are expected to move at."""
_SAMPLES = np.linspace(0.0, 1.0, 17)[1:, None]
_CLEARANCE = 0.02
"""The way to a posture keeps this clear of the robot itself and the floor [m]."""
_ANOTHER = 0.7
"""A posture is another one when a joint differs by this much [rad]."""


class Stance(NamedTuple):
    """How to stand for a goal."""

    q: Array
    """(7,) posture of the arm [rad]."""
    bTe: SE3
    """The hand in the base, for that posture."""
    reverse: bool
    """Whether the base goes there backwards."""

    def base_for(self, wTe: SE3) -> Planar:
        """Where the base must stand in the world for the hand to be at `wTe`.

        The heading turns the tool's rotation in the base into the goal's as well as a turn about
        the vertical can.
        """
        (a, b, c), (d, e, f), _ = self.bTe.rotation.tolist()
        (g, h, i), (j, k, m), _ = wTe.rotation.tolist()
        along = a * g + b * h + c * i + d * j + e * k + f * m
        across = a * j + b * k + c * m - d * g - e * h - f * i
        heading = atan2(across, along)
        cosine, sine = cos(heading), sin(heading)
        x, y, _ = self.bTe.translation.tolist()
        wx, wy, _ = wTe.translation.tolist()
        return Planar(wx - (cosine * x - sine * y), wy - (sine * x + cosine * y), heading)


def choose_stance(
    model: RobotModel,
    settings: ControllerSettings,
    bank: Bank,
    body: SelfCollision,
    wTe: SE3,
    base: Planar,
    q: Array,
    failed: tuple[Stance, ...] = (),
) -> Stance:
    """The stance that reaches a pose soonest, among those that are dexterous and in front.

    The bank's postures near the goal's height and tilt are ranked, the best are refined until they
    have exactly that height and tilt, and the best of those whose straight way in joint space is
    clear of contact is taken. If none is found in `_ROUNDS` rounds, the least bad one is.

    Args:
        model: the robot.
        settings: what a stance costs.
        bank: the postures to choose from.
        body: the robot's shapes.
        wTe: the pose to reach.
        base: where the base is.
        q: (7,) where the arm is [rad].
        failed: stances that were tried in vain, to choose another one.
    """
    near = _candidates(bank, wTe)
    costs = _costs(model, settings, wTe, base, q, bank.q[near], _rows(bank.hands, near))[0]
    ranked = near[np.argsort(costs)]
    best: tuple[float, Stance] | None = None
    for number in range(_ROUNDS):
        some = ranked[number * _REFINED : (number + 1) * _REFINED]
        if len(some) == 0:
            break
        refined, left = _refine(model, wTe, bank.q[some])
        there = hands(model.description, refined)
        costs, reverse = _costs(model, settings, wTe, base, q, refined, there)
        costs = costs + np.where(left > _EXACT, 100.0 + 100.0 * left, 0.0)
        for stance in failed:
            same = np.abs(refined - stance.q).max(axis=1) < _ANOTHER
            costs = costs + np.where(same, 50.0, 0.0)
        for one in np.argsort(costs):
            cost = float(costs[one])
            if best is not None and cost >= best[0]:
                break
            cost += 1000.0 * max(0.0, _CLEARANCE - _clearance_on_the_way(body, q, refined[one]))
            if best is None or cost < best[0]:
                pose = SE3(there.rotations[one], there.positions[one])
                best = cost, Stance(refined[one], pose, bool(reverse[one]))
        if best is not None and best[0] < 50.0:
            break
    assert best is not None
    return best[1]


def _rows(where: Hands, index: Indices) -> Hands:
    return Hands(*(values[index] for values in where))


def _candidates(bank: Bank, wTe: SE3) -> Indices:
    """Indices of the postures whose hand is about as high and as tilted as the goal."""
    height, down = wTe.translation[2], wTe.rotation[2]
    for window, least_cosine in _WINDOWS:
        first, last = np.searchsorted(
            bank.hands.positions[:, 2], [height - window, height + window]
        )
        found: Indices = first + np.flatnonzero(
            bank.hands.rotations[first:last, 2] @ down > least_cosine
        )
        if len(found) >= _ENOUGH:
            return found
    off = np.abs(bank.hands.positions[:, 2] - height) - 0.3 * (bank.hands.rotations[:, 2] @ down)
    nearest: Indices = np.argpartition(off, _NEAREST)[:_NEAREST]
    return nearest


def _bases(wTe: SE3, positions: Array, rotations: Array) -> Array:
    """x, y, heading (N, 3) of the bases that have the hand at `wTe`, given the hands in them."""
    R, p = wTe.rotation, wTe.translation
    c = rotations[:, 0] @ R[0] + rotations[:, 1] @ R[1]
    s = rotations[:, 0] @ R[1] - rotations[:, 1] @ R[0]
    heading = np.arctan2(s, c)
    c, s = np.cos(heading), np.sin(heading)
    x, y = positions[:, 0], positions[:, 1]
    return np.stack([p[0] - (c * x - s * y), p[1] - (s * x + c * y), heading], axis=1)


def _costs(
    model: RobotModel,
    settings: ControllerSettings,
    wTe: SE3,
    base: Planar,
    q: Array,
    postures: Array,
    there: Hands,
) -> tuple[Array, Array]:
    """What N postures cost, about in seconds, and whether the base goes there backwards."""
    limits = model.limits
    driving, reverse = _driving(model, base, _bases(wTe, there.positions, there.rotations))
    folding = (np.abs(postures - q) / (_ARM_SPEED * limits.qd)).max(axis=1)
    margin = np.minimum(postures - limits.q_min, limits.q_max - postures).min(axis=1)
    bearing = np.abs(np.arctan2(there.positions[:, 1], there.positions[:, 0]))
    cost = (
        np.maximum(driving, folding)
        + 0.3 * np.minimum(driving, folding)
        + settings.dexterity_cost * np.maximum(0.0, settings.dexterity - there.manipulability)
        + settings.bearing_cost * bearing
        + 2.0 * np.maximum(0.0, _FAR_FROM_LIMITS - margin)
    )
    return cost, reverse


def _driving(model: RobotModel, base: Planar, bases: Array) -> tuple[Array, Array]:
    """Times (N,) to drive to the bases (N, 3), and whether backwards is faster."""
    v, _, w = model.limits.base_twist
    dx, dy = bases[:, 0] - base.x, bases[:, 1] - base.y
    distance, turn = np.hypot(dx, dy), _wrapped(bases[:, 2] - base.heading)
    if model.n_base == 3:
        return np.maximum(distance / v, np.abs(turn) / w), np.zeros(len(bases), bool)
    way = _wrapped(np.arctan2(dy, dx) - base.heading)
    back = _wrapped(way + pi)
    forward = (np.abs(way) + np.abs(_wrapped(turn - way))) / w
    backward = (np.abs(back) + np.abs(_wrapped(turn - back))) / w + _REVERSE_COST
    return distance / v + 1.2 * np.minimum(forward, backward), backward < forward


def _wrapped(angles: Array) -> Array:
    wrapped: Array = (angles + pi) % (2.0 * pi) - pi
    return wrapped


def _refine(model: RobotModel, wTe: SE3, q: Array) -> tuple[Array, Array]:
    """Move postures (N, 7) until their hands have the height and tilt of the goal.

    Damped least squares on three equations: height, and the two angles of the vertical as the hand
    sees it. The first joint changes neither and stays. Joints that come near a limit stay there.

    Returns:
        Postures (N, 7), and what is left of height and tilt of each (N,) [m + rad].
    """
    low, high = model.limits.q_min + _LIMIT_MARGIN, model.limits.q_max - _LIMIT_MARGIN
    height, down = wTe.translation[2], wTe.rotation[2]
    for _ in range(_ITERATIONS):
        where = hands(model.description, q)
        seen = where.rotations @ down  # the goal's vertical; (0, 0, 1) where the tilt is right
        sine = np.hypot(seen[:, 0], seen[:, 1])
        scale = np.arctan2(sine, seen[:, 2]) / np.maximum(sine, 1e-9)
        error = np.stack(
            [height - where.positions[:, 2], seen[:, 1] * scale, -seen[:, 0] * scale], axis=1
        )
        left: Array = np.abs(error).sum(axis=1)
        if (left < _EXACT).all():
            break
        rows = where.J[:, [2, 3, 4]]
        rows[:, :, 0] = 0.0
        step = _damped(rows, np.clip(error, -0.5, 0.5))
        stuck = (q + step < low) | (q + step > high)
        step = _damped(np.where(stuck[:, None, :], 0.0, rows), np.clip(error, -0.5, 0.5))
        q = np.clip(q + step, low, high)
    return q, left


def _damped(rows: Array, error: Array) -> Array:
    """Least-squares steps (N, 7) for rows (N, 3, 7) and errors (N, 3)."""
    across = np.swapaxes(rows, 1, 2)
    square = rows @ across + 1e-4 * np.eye(3)
    return (across @ np.linalg.solve(square, error[:, :, None]))[:, :, 0]


def _clearance_on_the_way(body: SelfCollision, q: Array, there: Array) -> float:
    """Smallest clearance on the straight way from one posture to another [m]."""
    return min(body.clearance(posture) for posture in q + _SAMPLES * (there - q))
