"""Inverse kinematics of the arm with the base at rest: postures and straight paths of the hand."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import Array
from controller.floor.base_drive import Pose2D, wrap
from controller.model import RobotModel
from controller.stance.posture_bank import PostureBank
from controller.stance.stance import REACHED, refine_standing

_METRES_PER_TILT = 0.3
"""Distance equivalent to the cosine of a tilt where postures are compared [m]."""
_SEEDS = 60  # number of postures of the bank that the solver starts from
_SAME = 0.05  # largest joint difference of postures that count as the same [rad]


def postures_at(model: RobotModel, bank: PostureBank, wTb: SE3, wTe: SE3, q: Array) -> Array:
    """Postures (N, 7) with the end effector at `wTe`, the nearest to q (7,) first; N may be 0."""
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
    found = _solved(model, wTb, wTe, np.vstack([q, postures]))
    found = found[np.argsort(np.abs(found - q).max(axis=1))]
    kept: list[Array] = []
    for one in found:
        if all(np.abs(one - other).max() > _SAME for other in kept):
            kept.append(one)
    return np.array(kept).reshape(-1, len(q))


def straight_postures(
    model: RobotModel, wTb: SE3, wTe: SE3, q: Array, step: float, jump: float
) -> Array | None:
    """Postures (M, 7) from q (7,) on the straight line of the hand to `wTe`; None if there is none.

    `step` [m] and `jump` [rad] are the largest distance of the hand and the largest joint
    difference between two of them.
    """
    here = model.wTe(wTb, q)
    turn = pin.log3(here.actInv(wTe).rotation)
    distance = float(np.linalg.norm(wTe.translation - here.translation))
    count = max(2, int(np.ceil(max(distance, 0.3 * float(np.linalg.norm(turn))) / step)))
    path = [q]
    for share in np.arange(1, count + 1) / count:
        between = here.translation + share * (wTe.translation - here.translation)
        pose = SE3(here.rotation @ pin.exp3(share * turn), between)
        found = _solved(model, wTb, pose, path[-1][None])
        if not len(found) or np.abs(found[0] - path[-1]).max() > jump:
            return None
        path.append(found[0])
    return np.array(path)


def _solved(model: RobotModel, wTb: SE3, wTe: SE3, seeds: Array) -> Array:
    """The postures that the solver finds from postures (N, 7)."""
    base = np.tile(np.array(Pose2D.of(wTb)), (len(seeds), 1))
    found, errors = refine_standing(model, wTe, seeds, base)
    return found[errors <= REACHED]
