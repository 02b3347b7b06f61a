"""Postures that bring the hand to a pose, the base standing where it is."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array
from controller.floor import Pose2D, wrap
from controller.model import RobotModel
from controller.stance import REACHED, PostureBank, refine_standing
from controller.stance_settings import StanceSettings

_METRES_PER_TILT = 0.3
"""What the cosine of a tilt counts like where postures are compared [m]."""
_SEEDS = 60
"""Postures of the bank that are brought to the pose."""
_ALIKE = 0.05
"""Postures of which no joint differs by more are one [rad]."""


def postures_at(
    model: RobotModel, settings: StanceSettings, bank: PostureBank, wTb: SE3, wTe: SE3, q: Array
) -> Array:
    """Postures (N, 7) with the end effector at `wTe`, the nearest to q (7,) first; N may be 0.

    Args:
        model: the robot.
        settings: how near to a limit a joint may come.
        bank: good postures, to start from.
        wTb: base pose.
        wTe: where the end effector is to be.
        q: where the arm is [rad].
    """
    bTe, foot = wTb.actInv(wTe), model.description.bTa.translation
    away = bTe.translation - foot
    tools = bank.tools
    theirs = tools.positions - foot
    reach = np.hypot(theirs[:, 0], theirs[:, 1]) - np.hypot(away[0], away[1])
    tilt = 1.0 - tools.rotations[:, 2] @ bTe.rotation[2]
    apart = np.abs(reach) + np.abs(theirs[:, 2] - away[2]) + _METRES_PER_TILT * tilt
    seeds = np.argpartition(apart, _SEEDS)[:_SEEDS]
    postures = bank.q[seeds]
    turn = np.arctan2(away[1], away[0]) - np.arctan2(theirs[seeds, 1], theirs[seeds, 0])
    postures[:, 0] = wrap(postures[:, 0] + turn)
    found = _brought(model, settings, wTb, wTe, np.vstack([q, postures]))
    found = found[np.argsort(np.abs(found - q).max(axis=1))]
    kept: list[Array] = []
    for one in found:
        if all(np.abs(one - other).max() > _ALIKE for other in kept):
            kept.append(one)
    return np.array(kept).reshape(-1, len(q))


def straight_postures(
    model: RobotModel,
    settings: StanceSettings,
    wTb: SE3,
    wTe: SE3,
    q: Array,
    step: float,
    jump: float,
) -> Array | None:
    """Postures (M, 7) on the straight way of the hand to `wTe`; None where it cannot go straight.

    Args:
        model: the robot.
        settings: how near to a limit a joint may come.
        wTb: base pose.
        wTe: where the end effector is to be.
        q: (7,) where the arm is [rad].
        step: largest distance between two of them [m].
        jump: largest difference of a joint between two of them [rad].
    """
    here = model.wTe(wTb, q)
    turn = pin.log3(here.actInv(wTe).rotation)
    distance = float(np.linalg.norm(wTe.translation - here.translation))
    count = max(2, int(np.ceil(max(distance, 0.3 * float(np.linalg.norm(turn))) / step)))
    path = [q]
    for share in np.arange(1, count + 1) / count:
        between = here.translation + share * (wTe.translation - here.translation)
        pose = SE3(here.rotation @ pin.exp3(share * turn), between)
        found = _brought(model, settings, wTb, pose, path[-1][None])
        if not len(found) or np.abs(found[0] - path[-1]).max() > jump:
            return None
        path.append(found[0])
    return np.array(path)


def _brought(
    model: RobotModel, settings: StanceSettings, wTb: SE3, wTe: SE3, seeds: Array
) -> Array:
    """Those of postures (N, 7) that can be brought to the pose, brought there."""
    base = np.tile(np.array(Pose2D.of(wTb)), (len(seeds), 1))
    found, errors = refine_standing(model, settings, wTe, seeds, base)
    return found[errors <= REACHED]
