"""Shapes that a robot is drawn with, each in the frame of its body."""

from dataclasses import replace

import numpy as np
from pinocchio import SE3

from robots import (
    ArmDescription,
    BaseDescription,
    Box,
    Colour,
    Geom,
    GripperDescription,
    RobotDescription,
)

_WHITE: Colour = (225, 226, 230)
_SHELL: Colour = (190, 194, 200)
_DARK: Colour = (62, 66, 74)
_ORANGE: Colour = (245, 170, 40)
_HALF_TURN = SE3(np.diag([-1.0, -1.0, 1.0]), np.zeros(3))


def _at(x: float, y: float, z: float) -> SE3:
    return SE3(np.eye(3), np.array([x, y, z]))


def arm_parts(arm: ArmDescription) -> tuple[tuple[Geom, ...], ...]:
    """Foot and links of an arm as its collision shapes, each in its own frame."""
    return tuple(tuple(replace(part, colour=_WHITE) for part in parts) for parts in arm.collision)


def hand_parts(robot: RobotDescription) -> tuple[Geom, Geom]:
    """Palm and camera, in the frame of the hand's flange."""
    hTe = robot.gripper.hTe
    return robot.gripper.palm.moved(hTe), robot.camera.body.moved(hTe * robot.camera.eTc)


def finger_poses(gripper: GripperDescription, width: float) -> tuple[SE3, SE3]:
    """Frames of the left and the right finger on the flange, `width` [m] between the pads.

    A finger's frame has its origin beside the grasp centre, on the inner face of the pad, and the
    other finger in -y.
    """
    left = _at(0.0, width / 2, 0.0)
    return gripper.hTe * left, gripper.hTe * _HALF_TURN * left


def base_parts(base: BaseDescription) -> tuple[Geom, ...]:
    """A mobile base in its frame, which lies on the floor: body, lid and nose."""
    length, width, height = base.size
    half = (length / 2, width / 2, height / 2 - 0.03)
    lid = (length / 2 - 0.02, width / 2 - 0.02, 0.01)
    nose = (0.01, width / 2 - 0.08, 0.02)
    return (
        Geom(Box(half), _at(0.0, 0.0, height / 2 + 0.01), colour=_DARK),
        Geom(Box(lid), _at(0.0, 0.0, height - 0.01), colour=_SHELL),
        Geom(Box(nose), _at(length / 2, 0.0, height * 0.6), colour=_ORANGE),
    )
