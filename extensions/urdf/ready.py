"""The ready posture of any arm: the hand in front and pointing down, dexterous, clear of itself."""

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from config.planar import wrap
from controller import (
    SEED,
    RobotModel,
    SelfCollision,
    dexterity,
    forward_kinematics,
    manipulabilities,
    refine,
    stance_margins,
    uniform_postures,
)
from robots import RobotDescription

_DRAWN, _REFINED = 30_000, 600  # postures that are drawn, and the likely ones that are made level
_HEIGHT, _AHEAD = 0.8, 0.4  # of the hand [m], and its distance to the foot as a share of its reach
_FROM_FOOT = 0.5  # largest height above or below the foot, as a share of its reach
_CLEARANCE = 0.03  # to itself that is enough [m]
_FOLDED = 0.1  # cost of a joint per radian from its zero, in radians of tilt
_DEXTEROUS = 0.08  # manipulability that is enough, of an arm like a Panda


def ready_posture(robot: RobotDescription) -> Array:
    """(j,) joint positions [rad]; of an arm that cannot point down, the nearest to it."""
    model, rng = RobotModel(robot), np.random.default_rng(SEED)
    dexterous = dexterity(robot)
    (low, high), margins = robot.limits.within_a_turn, stance_margins(robot)
    q = uniform_postures(robot, rng, low + margins, high - margins, _DRAWN)
    swivel = robot.swivel
    foot = robot.bTa.translation if swivel is None else swivel.pivot
    reach = float(np.linalg.norm(forward_kinematics(robot, q).positions - foot, axis=1).max())
    between = foot[2] - _FROM_FOOT * reach, foot[2] + _FROM_FOOT * reach
    height = float(np.clip(_HEIGHT, *between))
    down = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, height]))

    def faults(q: Array) -> Array:
        """(N,) how far postures are from ready."""
        tools = forward_kinematics(robot, q)
        p, R = tools.positions - foot, tools.rotations
        away, bearing = np.hypot(p[:, 0], p[:, 1]), dexterous.bearing_of(p[:, 0], p[:, 1])
        ahead = away if swivel is not None else away * np.cos(bearing)
        aside = 0.0 if swivel is not None else np.abs(away * np.sin(bearing))
        ends = np.minimum(q - robot.limits.q_min, robot.limits.q_max - q)
        folds = _FOLDED * np.abs(q[:, :-1]).sum(axis=1)
        near = np.maximum(0.0, 3.0 * margins - ends).sum(axis=1)
        stiff = (
            np.maximum(0.0, _DEXTEROUS - manipulabilities(robot, tools) / dexterous.usual)
            / _DEXTEROUS
        )
        off = np.abs(ahead - _AHEAD * reach) + aside + np.abs(tools.positions[:, 2] - height)
        return np.asarray(
            3.0 * off / reach + np.arccos(np.clip(-R[:, 2, 2], -1, 1)) + stiff + near + folds
        )

    q = refine(model, down, q[np.argsort(faults(q))[:_REFINED]])[0]
    tools = forward_kinematics(robot, q)
    if swivel is not None:
        x, y, _ = (tools.positions - foot).T
        q[:, swivel.joint] = wrap(q[:, swivel.joint] - swivel.sign * np.arctan2(y, x))
    if not robot.arm.slides[-1]:  # its x ahead, where that is a matter of the last joint
        R = forward_kinematics(robot, q).rotations
        lTe = robot.arm.lTh * robot.gripper.hTe
        yaw = dexterous.bearing_of(R[:, 0, 0], R[:, 1, 0])
        q[:, -1] += yaw * round(float(lTe.rotation[2, 2]))
        q[:, -1] = np.where(q[:, -1] > robot.limits.q_max[-1], q[:, -1] - 2.0 * np.pi, q[:, -1])
        q[:, -1] = np.where(q[:, -1] < robot.limits.q_min[-1], q[:, -1] + 2.0 * np.pi, q[:, -1])
    inside = (q > robot.limits.q_min) & (q < robot.limits.q_max)
    R = forward_kinematics(robot, q).rotations
    order = np.argsort(faults(q) + (1.0 - np.cos(dexterous.bearing_of(R[:, 0, 0], R[:, 1, 0]))))
    body = SelfCollision(model)
    rooms = np.array([body.clearance(q[number]) for number in order])
    rooms -= (~inside[order]).any(axis=1)  # the last ones
    enough = np.flatnonzero(rooms > min(_CLEARANCE, float(rooms.max()) - 1e-9))
    return np.asarray(np.clip(q[order[enough[0]]], robot.limits.q_min, robot.limits.q_max))
