"""The hand in the world: palm, fingers and pads of the robot's gripper at a pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from robots import Array, Geom, GripperDescription, bounding_radius

SIDES = {"left": 1.0, "right": -1.0}  # The side along y of the end effector on which each finger is


@dataclass(frozen=True, eq=False)
class Hand:
    """A gripper whose end effector is at a pose, at any opening.

    Widths are distances between the two pads [m].
    """

    gripper: GripperDescription
    wTe: SE3  # End effector in the world: z along the approach, y the closing direction

    @property
    def centre(self) -> Array:
        """(3,) centre of a ball around the hand at any opening, in the world [m]."""
        centre: Array = self.wTe.act(self.gripper.ball.pose.translation)
        return centre

    @property
    def radius(self) -> float:
        """Radius of that ball [m]."""
        return bounding_radius(self.gripper.ball.shape)

    def inwards(self, side: str) -> Array:
        """(3,) direction in the world in which the finger of a side closes."""
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
        """A part of a finger that is described on the left, when the pads touch."""
        x, y, z = part.pose.translation
        eTp = SE3(part.pose.rotation, np.array([x, SIDES[side] * (from_centre + y), z]))
        return Geom(part.shape, self.wTe * eTp, f"{side} {part.name}", part.colour)
