"""Pointing the wrist camera: where it is, and where the hand must be for a view."""

from __future__ import annotations

from math import atan2, hypot
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pinocchio import SE3

from behaviours.context import Context
from controller import Command

Array: TypeAlias = npt.NDArray[np.float64]

_SOON = 0.01  # over this time velocities are taken for constant [s]


def camera_pose(context: Context) -> SE3:
    """Camera in the world, as read this tick."""
    return context.wTe * context.robot.description.camera.eTc


def hand_for(context: Context, wTc: SE3) -> SE3:
    """Where the end effector is when the camera is at `wTc`; both in the world."""
    return wTc * context.robot.description.camera.eTc.inverse()


def straight_down(point: Array, height: float, like: SE3) -> SE3:
    """A camera that looks straight down.

    Args:
        point: (3,) what it looks at, in the world [m].
        height: above that [m].
        like: camera in the world whose turn about the vertical it keeps.

    Returns:
        Camera in the world.
    """
    x_axis = like.rotation[:, 0]
    rotation = pin.rpy.rpyToMatrix(np.pi, 0.0, atan2(x_axis[1], x_axis[0]))
    return SE3(rotation, point + np.array([0.0, 0.0, height]))


def turned_towards(wTc: SE3, point: Array, distance: float | None) -> SE3:
    """A camera turned by the least angle that lets it look at a point.

    Args:
        wTc: the camera before, in the world.
        point: (3,) what it shall look at [m].
        distance: from the point, on the line of sight [m]; None leaves the camera where it is.
    """
    away = point - wTc.translation
    sight = away / max(float(np.linalg.norm(away)), 1e-9)
    turn = pin.Quaternion.FromTwoVectors(wTc.rotation[:, 2], sight).toRotationMatrix()
    eye = wTc.translation if distance is None else point - distance * sight
    return SE3(turn @ wTc.rotation, eye)


def back_over(wTg: SE3, context: Context) -> SE3:
    """Where a hand on its way down on a grasp goes: to it, or back over it if it has strayed."""
    settings = context.settings.grasp
    x, y, z = wTg.actInv(context.wTe.translation)
    if hypot(x, y) <= settings.astray or -z <= settings.astray_above:
        return wTg
    return wTg * SE3(np.eye(3), np.array([0.0, 0.0, z]))


def is_at_rest(context: Context) -> bool:
    """Whether the hand stands still, as read this tick, however base and arm move behind it."""
    state, model = context.state, context.model
    moves = Command(base_twist=state.base_twist, qd=state.qd)
    twist = model.kinematics(state.q).J @ model.velocities(moves)
    return bool(np.abs(twist).max() <= context.settings.view.at_rest)


def sinking(context: Context) -> float:
    """How fast the arm lowers the hand, as read this tick [m/s]."""
    model, state = context.model, context.state
    soon = model.bTe(state.q + _SOON * state.qd).translation
    return float(model.bTe(state.q).translation[2] - soon[2]) / _SOON
