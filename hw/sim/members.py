"""The shapes of the robot that can hit something, and how far each can have moved.

A shape of the arm moves at most as far as the base drives, plus every turn below it times its
lever: the longest way along the chain from that axis to the shape's farthest point. The levers of a
shape are one row of numbers, so that the travel of all shapes is one product with the motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from controller import RobotModel
from hw.sim.hand import Hand
from hw.sim.sim_object import SimObject
from robots import Array, Box, Geom, RobotDescription, bounding_radius

HAND_TOLERANCE = 0.002
"""Depth to which the robot may press into something before it counts as a collision [m]."""

HELD_TOLERANCE = 0.005  # The same for a held object, which yields in the fingers [m]

BASE, HAND, FINGERS, CAMERA, HELD = "base", "hand", "fingers", "camera", "held object"
"""Names of parts; the arm's are `link0`, its foot, to `link7`."""

_FRAMES = 11
"""The base, the foot and seven links of the arm, the flange of the hand and the end effector."""
_HAND_FRAME, _TOOL_FRAME = 9, 10


@dataclass(frozen=True, eq=False)
class Member:
    """One shape of the robot."""

    part: str
    frame: int  # Which frame it moves with
    geom: Geom  # In that frame; a finger's place depends on the width besides
    tolerance: float
    levers: Array
    """(10,) travel per driven metre, turn of the base, turn of each joint, and motion of a finger
    [m, m/rad, m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Configuration:
    """Where the robot is."""

    wTb: SE3
    q: Array  # (7,) [rad]
    width: float  # Between the pads [m]

    def motion(self, since: Configuration) -> Array:
        """(10,) how far it is from another one: driven, turned, joints, finger [m, rad, m]."""
        (x, y, _), (u, v, _) = self.wTb.translation, since.wTb.translation
        (a, b), (c, s) = self.wTb.rotation[:2, 0], since.wTb.rotation[:2, 0]
        turn = np.arctan2(b * c - a * s, a * c + b * s)
        finger = (self.width - since.width) / 2.0
        return np.abs((np.hypot(x - u, y - v), turn, *(self.q - since.q), finger))


def members(robot: RobotDescription) -> list[Member]:
    """The shapes of a robot."""
    hand = Hand(robot.gripper, SE3.Identity()).shapes(robot.gripper.opening)
    palm, *fingers = hand
    own = [_member(robot, HAND, _TOOL_FRAME, palm)]
    own += [_member(robot, FINGERS, _TOOL_FRAME, part) for part in fingers]
    arm = [
        _member(robot, f"link{link}", link + 1, shape)
        for link, shapes in enumerate(robot.arm.collision)
        for shape in shapes
    ]
    length, width, height = robot.base.size
    middle = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
    box = Geom(Box((length / 2.0, width / 2.0, height / 2.0)), middle, BASE)
    camera = robot.camera.body.moved(robot.camera.eTc)
    return [
        _member(robot, BASE, 0, box),
        *arm,
        *own,
        _member(robot, CAMERA, _TOOL_FRAME, camera),
    ]


def held_members(robot: RobotDescription, held: SimObject, eTo: SE3) -> list[Member]:
    """The shapes of what the hand holds."""
    return [_member(robot, HELD, _TOOL_FRAME, part) for part in held.placed(eTo)]


def frames(model: RobotModel, wTb: SE3, q: Array) -> tuple[SE3, ...]:
    """The frames of a robot's shapes in the world, for q (7,) [rad]."""
    links = model.link_poses(wTb, q)
    return (wTb, *links, links[-1] * model.description.gripper.hTe)


def _member(robot: RobotDescription, part: str, frame: int, geom: Geom) -> Member:
    tolerance = HELD_TOLERANCE if part == HELD else HAND_TOLERANCE
    return Member(part, frame, geom, tolerance, _levers(robot, part, frame, geom))


def _levers(robot: RobotDescription, part: str, frame: int, geom: Geom) -> Array:
    radius, levers = bounding_radius(geom.shape), np.zeros(10)
    levers[0] = 1.0
    levers[9] = float(part == FINGERS)
    if frame == 0:
        levers[1] = float(np.hypot(*geom.pose.translation[:2])) + radius
        return levers
    place = geom.pose
    if frame == _TOOL_FRAME:
        place = robot.arm.lTh * robot.gripper.hTe * place
    lever = float(np.linalg.norm(place.translation)) + radius
    for joint in range(min(frame - 1, 7), 0, -1):
        levers[1 + joint] = lever
        lever += float(np.linalg.norm(robot.arm.joints[joint - 1].translation))
    levers[1] = lever + float(np.hypot(*robot.bTa.translation[:2]))
    return levers
