"""The goals of Experiment 2: drawn with a seed and known to be reachable, or from a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pinocchio import SE3

from config import UserError
from controller import Array, RobotModel
from lab.bench.contacts import ContactChecker
from robots import reach

PLACES = ("anywhere", "near", "far", "floor", "above")
"""Where goals can be: in the disc, within 1 m, between 3.5 and 4 m, low, or above the base."""
_PARTS = {"near": (0.0, 1.0), "far": (3.5, 4.0), "above": (0.0, 0.35)}
"""Nearest and farthest of these from the start [m]."""
_LOW, _HIGH = 0.15, 0.8
"""Goals at the floor are lower than this, goals above the base higher [m]."""
DISC = 4.0
"""Goals are nearer to the start than this [m]."""
_MARGIN = 0.1
"""Drawn postures keep this distance from every joint limit [rad]."""
_LOWEST = 0.05
"""Tool and flange are at least this far above the floor [m]."""
_PALM_LOWEST = 0.005
"""The corners of the palm are at least this far above the floor where goals are low: the capsules
around the hand leave them free [m]."""
_POSE_TOLERANCE = 1e-4
"""Poses in a file may differ from a rigid motion by this much, as in single precision."""


class GoalFileError(UserError):
    """A file of goals cannot be used."""


def generate_goals(model: RobotModel, count: int, seed: int, where: str = "anywhere") -> list[SE3]:
    """Poses `wTe` of the tool that the robot can reach without contact.

    A posture is drawn uniformly within the joint limits, the heading of the base uniformly, and
    the tool's place uniformly in a disc of 4 m around the start; the base stands where that puts
    it. Postures in which the arm touches itself, the base or the floor are left out.

    Args:
        model: the robot.
        count: number of goals.
        seed: the same seed gives the same goals.
        where: one of `PLACES`.
    """
    nearest, farthest = _PARTS.get(where, (0.0, DISC))
    rng = np.random.default_rng(seed)
    contacts = ContactChecker(model)
    limits = model.limits
    goals: list[SE3] = []
    while len(goals) < count:
        q = rng.uniform(limits.q_min + _MARGIN, limits.q_max - _MARGIN)
        heading = rng.uniform(-np.pi, np.pi)
        radius = np.sqrt(rng.uniform(nearest**2, farthest**2))
        bearing = rng.uniform(-np.pi, np.pi)
        tool = model.bTe(q)
        height = float(tool.translation[2])
        if (where == "floor" and height > _LOW) or (where == "above" and height < _HIGH):
            continue
        flange = model.link_poses(SE3.Identity(), q)[-1].translation[2]
        if min(height, flange) < _LOWEST or np.hypot(radius, height) > DISC or contacts(q).any:
            continue
        if where == "floor" and _palm_height(model, tool) < _PALM_LOWEST:
            continue
        place = np.array([radius * np.cos(bearing), radius * np.sin(bearing), height])
        goals.append(SE3(pin.utils.rotate("z", heading) @ tool.rotation, place))
    return goals


def _palm_height(model: RobotModel, tool: SE3) -> float:
    """Of the lowest corner of the palm above the floor [m]."""
    return -reach(model.description.gripper.palm.moved(tool), np.array([0.0, 0.0, -1.0]))


def load_goals(path: Path) -> list[SE3]:
    """The poses in a file.

    Args:
        path: an .npz file whose array `T` (N, 4, 4) holds poses of the tool in the world.

    Raises:
        GoalFileError: it cannot be read, or does not hold poses.
    """
    try:
        content = np.load(path, allow_pickle=False)
        arrays = dict(content) if isinstance(content, np.lib.npyio.NpzFile) else None
    except FileNotFoundError:
        raise GoalFileError(f"--goals {path}: there is no such file") from None
    except Exception as error:
        raise GoalFileError(f"--goals {path}: not a readable .npz file ({error})") from None
    if arrays is None:
        raise GoalFileError(f"--goals {path}: one bare array; save it with np.savez(file, T=poses)")
    if "T" not in arrays:
        has = ", ".join(sorted(arrays)) or "nothing"
        raise GoalFileError(f"--goals {path}: has {has} but no array T of shape (N, 4, 4)")
    poses = arrays["T"]
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or not len(poses):
        raise GoalFileError(
            f"--goals {path}: T must have shape (N, 4, 4), N > 0; got {poses.shape}"
        )
    if poses.dtype.kind not in "fiu":
        raise GoalFileError(f"--goals {path}: T must hold numbers, got {poses.dtype}")
    return [_pose(path, number, np.asarray(T, float)) for number, T in enumerate(poses)]


def _pose(path: Path, number: int, T: npt.NDArray[np.float64]) -> SE3:
    if not np.isfinite(T).all():
        raise GoalFileError(f"--goals {path}: T[{number}] has numbers that are not finite")
    R = T[:3, :3]
    nearest = _nearest_rotation(R)
    off = max(float(np.abs(R - nearest).max()), float(np.abs(T[3] - [0, 0, 0, 1]).max()))
    if off > _POSE_TOLERANCE:
        raise GoalFileError(
            f"--goals {path}: T[{number}] is not a pose: a rotation, a position and the last row"
            " 0 0 0 1"
        )
    return SE3(nearest, T[:3, 3].copy())


def _nearest_rotation(R: Array) -> Array:
    U, _, Vt = np.linalg.svd(R)
    turn = np.diag([1.0, 1.0, np.linalg.det(U @ Vt)])
    return np.asarray(U @ turn @ Vt, float)
