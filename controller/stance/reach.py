"""Reach: which poses of the hand a robot reaches on an open floor, and what would do instead.

The base stands wherever it has to, so only height and tilt of the hand count: a pose is within
reach if inverse kinematics has them from one of the nearest postures of the bank.
"""

from functools import lru_cache

import numpy as np
from pinocchio import SE3, exp3

from config.planar import ORIGIN, Pose2D, wrap
from config.poses import MapPose
from controller.model import RobotModel
from controller.stance.bank_drawing import stored_postures
from controller.stance.free_space import se3_of
from controller.stance.posture_bank import PostureBank, nearest
from controller.stance.stance import refine, refine_standing
from controller.stance.tool_poses import forward_kinematics
from robots import RobotDescription

REACHED = 0.01  # largest error of a pose that is within reach [m + rad]
_TRIED = 40  # postures from which inverse kinematics starts
_ROUNDS = 4  # of inverse kinematics of an arm whose base stands still
_EVERY = 4  # inverse kinematics starts from every fourth stored posture
_STEP, _TURN = 0.02, np.deg2rad(10.0)  # of the heights and tilts that are tried instead [m, rad]
_WAYS = 8  # directions in which a hand is tilted
_DRAWN = 400  # postures of which the farthest counts
_OUTWARDS = 0.95  # least cosine between the direction of a tilted hand and that away from the base


def reach_error(robot: RobotDescription, mTe: MapPose) -> float:
    """Least error of height and tilt with which any posture has the hand at a pose [m + rad]."""
    model, postures = reach_postures(robot)
    return float(refine(model, mTe, postures.q[nearest(postures, mTe, _TRIED)])[1].min())


@lru_cache(maxsize=4)
def reach_postures(robot: RobotDescription) -> tuple[RobotModel, PostureBank]:
    """The model of a robot, and the postures from which inverse kinematics starts."""
    q = stored_postures(robot, every=_EVERY)
    return RobotModel(robot), PostureBank(q, forward_kinematics(robot, q), robot.swivel)


def _standing_error(robot: RobotDescription, mTe: MapPose, mTb: Pose2D) -> float:
    """Least error with which any posture has the hand at a pose, the base at `mTb` [m + rad]."""
    model, bank = reach_postures(robot)
    bTe = se3_of(mTb).inverse() * mTe
    q, tools, swivel = bank.q.copy(), bank.tools, bank.swivel
    if swivel is not None:  # it looks to the goal
        pivot = swivel.pivot[:2]
        seen = tools.positions[:, :2] - pivot
        ahead = np.arctan2(*(bTe.translation[:2] - pivot)[::-1])
        turns = wrap(ahead - np.arctan2(seen[:, 1], seen[:, 0]))
        q[:, swivel.joint] += swivel.sign * turns
        tools = tools.turned(swivel, turns)
    off = np.linalg.norm(tools.positions - bTe.translation, axis=1)
    turned = np.einsum("nij,ij->n", tools.rotations, bTe.rotation)  # the trace of the rest
    q = q[np.argsort(off - 0.3 * turned)[:_TRIED]]
    for _ in range(_ROUNDS):
        q, errors = refine_standing(model, bTe, q, np.zeros((len(q), 3)))
    return float(errors.min())


def out_of_reach(
    robot: RobotDescription, mTe: MapPose, error: float = REACHED, mTb: Pose2D = ORIGIN
) -> str:
    """Why no base pose lets the hand reach a pose with at most this error; empty if one does.

    `mTb` is where the base is, which counts for one that stands still.
    """
    if not robot.stands_still:
        return "" if reach_error(robot, mTe) <= error else beyond_reach(mTe)
    why = "the base stands still, and the arm does not get there"
    return "" if _standing_error(robot, mTe, mTb) <= error else why


def beyond_reach(mTe: MapPose) -> str:
    """The message about a pose that is out of reach."""
    return f"{mTe.translation[2]:.2f} m up: tilted like this the hand does not get there"


def reached_instead(robot: RobotDescription, mTe: MapPose) -> str:
    """What would do instead of a pose that is out of reach: the nearest height, the least tilt."""
    x, y, z = mTe.translation
    if robot.stands_still:
        tilt = float(np.arccos(np.clip(-mTe.rotation[2, 2], -1.0, 1.0)))
        most = farthest(robot, z, tilt)
        return f"so high and tilted it gets {most:.2f} m from the middle of the base"

    def is_reached(*poses: SE3) -> bool:
        return any(not out_of_reach(robot, pose) for pose in poses)

    heights = (z + way * rise for rise in _STEP * np.arange(1, 101) for way in (-1.0, 1.0))
    at = ((h, SE3(mTe.rotation, np.array([x, y, h]))) for h in heights if h > 0.0)
    height = (f"give it a height of {h:.2f} m" for h, pose in at if is_reached(pose))
    turns = (turn for turn in _TURN * np.arange(1, 10) if is_reached(*_tilted(mTe, turn)))
    turned = (f"tilt the hand by {np.rad2deg(turn):.0f}°" for turn in turns)
    found = filter(None, (next(height, ""), next(turned, "")))
    return ", or ".join(found) or "give it another height and tilt"


def _tilted(mTe: MapPose, turn: float) -> list[SE3]:
    """The pose tilted by an angle, in several directions."""
    ways = np.linspace(0.0, 2.0 * np.pi, _WAYS, endpoint=False)
    axes = np.column_stack([np.cos(ways), np.sin(ways), np.zeros(_WAYS)])
    return [SE3(mTe.rotation @ exp3(turn * axis), mTe.translation) for axis in axes]


def farthest(robot: RobotDescription, height: float, tilt: float) -> float:
    """How far from the middle of the base the hand gets, pointing away from it.

    Args:
        robot: the robot.
        height: of the end effector [m].
        tilt: between its approach and straight down [rad].

    Returns:
        The largest horizontal distance that was found [m]; 0 where there is none.
    """
    model, postures = reach_postures(robot)
    down = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, height]))
    most = 0.0
    for mTe in _tilted(down, tilt):
        q, errors = refine(model, mTe, postures.q[nearest(postures, mTe, _DRAWN)])
        tools = forward_kinematics(robot, q[errors <= REACHED])
        away = np.linalg.norm(tools.positions[:, :2], axis=1)
        along = np.sum(tools.rotations[:, :2, 2] * tools.positions[:, :2], axis=1)
        outwards = along >= (_OUTWARDS * np.sin(tilt) - 0.05) * away
        most = max(most, float(away[outwards].max(initial=0.0)))
    return most
