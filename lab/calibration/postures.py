"""Postures of the arm from which the camera sees the board."""

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller import RobotModel
from lab.calibration.board import Array, Board, project
from lab.calibration.result import CalibrationError
from robots import RobotDescription

_REACH = np.array([0.35, 0.35, 0.35, 0.35, 0.6, 0.5, 0.9])  # of each joint [rad]
_CANDIDATES = 6000
_DEPTHS = (0.28, 0.65)  # of the board's middle in the camera's frame [m]
_STEEPEST = np.deg2rad(45.0)  # between the axes of camera and board
_MARGIN = 25.0  # of the board from the edge of the image [px]
_CLEARANCE = 0.12  # of the finger tips above the plane of the board [m]
_JOINT_MARGIN = 0.15  # from the joint limits [rad]
_ROTATION = 0.5  # weight of rotations in the distance of two postures [m/rad]


def aTe_of(model: RobotModel, q: Array) -> SE3:
    """The end effector on the arm's foot, for joint positions (j,) [rad]."""
    return model.description.bTa.actInv(model.bTe(q))


def postures(
    description: RobotDescription,
    model: RobotModel,
    first: Array,
    aTk: SE3,
    board: Board,
    count: int,
    rng: np.random.Generator,
) -> list[Array]:
    """Joint positions (j,) [rad] that show all of the board, as different as possible.

    They are near the first ones, and the hand stays above the plane of the board; other obstacles
    are unknown. `first` are joint positions (j,) from which the board is seen [rad], `aTk` is the
    approximate pose of the board on the arm's foot; the camera mount may be wrong by some
    centimetres. Raises CalibrationError: there are too few of them.
    """
    limits = description.limits
    low = np.maximum(first - _REACH, limits.q_min + _JOINT_MARGIN)
    high = np.minimum(first + _REACH, limits.q_max - _JOINT_MARGIN)
    found, poses = [], []
    for q in rng.uniform(low, np.maximum(high, low), (_CANDIDATES, 7)):
        aTe = aTe_of(model, q)
        if _shows(description, aTe, aTk, board):
            found.append(q)
            poses.append(aTe * description.camera.eTc)
    if len(found) < count:
        raise CalibrationError(
            f"only {len(found)} postures near this one show the board: begin 0.4 m above its "
            "middle, with the joints far from their ends"
        )
    return _short_way(first, [found[k] for k in _different(poses, count)])


def _shows(description: RobotDescription, aTe: SE3, aTk: SE3, board: Board) -> bool:
    camera = description.camera.intrinsics
    cTk = (aTe * description.camera.eTc).actInv(aTk)
    if not _DEPTHS[0] < cTk.act(board.centre)[2] < _DEPTHS[1]:
        return False
    if cTk.rotation[2, 2] < np.cos(_STEEPEST):
        return False
    tip = aTk.actInv(aTe * SE3(np.eye(3), np.array([0.0, 0.0, description.gripper.tip])))
    if tip.translation[2] > -_CLEARANCE:
        return False
    width, height = board.size
    outline = np.array([[0, 0, 0], [width, 0, 0], [0, height, 0], [width, height, 0]], dtype=float)
    pixels = project(cTk, outline, camera)
    last = np.array([camera.width, camera.height]) - _MARGIN
    return bool(((pixels > _MARGIN) & (pixels < last)).all())


def _different(poses: list[SE3], count: int) -> list[int]:
    """Numbers of poses, each as far from those before as possible."""
    turns = np.array([pin.log3(poses[0].rotation.T @ one.rotation) for one in poses])
    features = np.column_stack([_ROTATION * turns, [one.translation for one in poses]])
    chosen = [0]
    distance = np.full(len(poses), np.inf)
    while len(chosen) < count:
        newest = features[chosen[-1]]
        distance = np.minimum(distance, np.linalg.norm(features - newest, axis=1))
        chosen.append(int(distance.argmax()))
    return chosen


def _short_way(first: Array, goals: list[Array]) -> list[Array]:
    """The same postures, each followed by the nearest remaining one."""
    way, here, remaining = [], first, list(goals)
    while remaining:
        nearest = min(range(len(remaining)), key=lambda k: float(np.abs(remaining[k] - here).max()))
        here = remaining.pop(nearest)
        way.append(here)
    return way
