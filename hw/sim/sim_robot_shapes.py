"""Collision shapes of the simulated robot: hand, links and base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from controller import RobotModel
from hw.sim.sim_object import SimObject
from robots import Array, Box, Geom, GripperDescription, RobotDescription, bounding_radius

SIDES = {"left": 1.0, "right": -1.0}  # side of each finger along y of the end effector

HAND_TOLERANCE = 0.002  # penetration below which a contact is no collision [m]
HELD_TOLERANCE = 0.005  # the same for a held object, which yields in the fingers [m]

BASE, HAND, FINGERS, CAMERA, HELD = "base", "hand", "fingers", "camera", "held object"
"""Names of parts; the arm's are `link0`, its foot, to `linkJ`."""

_TOOL_FRAME = -1  # frames: base, foot and links of the arm, flange, end effector


@dataclass(frozen=True, eq=False)
class Hand:
    """The hand of the robot in the world, at any width between its pads [m]."""

    gripper: GripperDescription
    wTe: SE3  # end effector in the world: z along the approach, y the closing direction

    @property
    def centre(self) -> Array:
        """(3,) centre of a ball around the hand at any width, in the world [m]."""
        centre: Array = self.wTe.act(self.gripper.ball.pose.translation)
        return centre

    @property
    def radius(self) -> float:
        """Radius of that ball [m]."""
        return bounding_radius(self.gripper.ball.shape)

    def inwards(self, side: str) -> Array:
        """(3,) closing direction of a finger in the world."""
        direction: Array = -SIDES[side] * self.wTe.rotation[:, 1]
        return direction

    def pad(self, side: str, from_centre: float) -> Geom:
        """The pad of a side, its face `from_centre` [m] away from the grasp centre."""
        return self._placed(self.gripper.pad, side, from_centre)

    def shapes(self, width: float) -> list[Geom]:
        """The whole hand in the world."""
        shapes = [self.gripper.palm.moved(self.wTe)]
        for side in SIDES:
            shapes.append(self._placed(self.gripper.finger, side, width / 2.0))
            shapes.append(self.pad(side, width / 2.0))
        return shapes

    def _placed(self, part: Geom, side: str, from_centre: float) -> Geom:
        """A part of a finger, which is described for the left side of the closed hand."""
        x, y, z = part.pose.translation
        eTp = SE3(part.pose.rotation, np.array([x, SIDES[side] * (from_centre + y), z]))
        return Geom(part.shape, self.wTe * eTp, f"{side} {part.name}", part.colour)


@dataclass(frozen=True, eq=False)
class Member:
    """One collision shape of the robot."""

    part: str
    frame: int  # number of its frame
    geom: Geom  # in that frame; a finger also moves with the width
    tolerance: float = HAND_TOLERANCE  # penetration below which a contact is no collision [m]


def finger_side(member: Member) -> float:
    """The side of a finger along y of the end effector; 0 for what is none."""
    return SIDES[member.geom.name.split()[0]] if member.part == FINGERS else 0.0


def members(robot: RobotDescription) -> list[Member]:
    """The collision shapes of a robot."""
    palm, *fingers = Hand(robot.gripper, SE3.Identity()).shapes(robot.gripper.opening)
    length, width, height = robot.base.size
    middle = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
    box = Geom(Box((length / 2.0, width / 2.0, height / 2.0)), middle, BASE)
    arm = [
        Member(f"link{link}", link + 1, shape)
        for link, shapes in enumerate(robot.arm.collision)
        for shape in shapes
    ]
    return [
        Member(BASE, 0, box),
        *arm,
        Member(HAND, _TOOL_FRAME, palm),
        *(Member(FINGERS, _TOOL_FRAME, part) for part in fingers),
        Member(CAMERA, _TOOL_FRAME, robot.camera.body.moved(robot.camera.eTc)),
    ]


def held_members(held: SimObject, eTs: SE3) -> list[Member]:
    """The collision shapes of a held object."""
    return [Member(HELD, _TOOL_FRAME, part, HELD_TOLERANCE) for part in held.placed(eTs)]


def frames(model: RobotModel, wTb: SE3, q: Array) -> tuple[SE3, ...]:
    """The frames of the members in the world, for q (j,) [rad]."""
    links = model.link_poses(wTb, q)
    return (wTb, *links, links[-1] * model.description.gripper.hTe)
