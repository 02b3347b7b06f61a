"""What stands in a region, as the camera has seen it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pinocchio import SE3

    from perception.frame import Array, Mask
    from perception.objects.footprint import Footprint

REACH = 0.008
"""Grasps and points this far beside an object still belong to it [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DetectedObject:
    """One object of a region; it is a `Workspace` that no grasp of its neighbours lies in."""

    wTo: SE3
    """Middle of the box around it, turned about z only: x along its longer edge seen from above."""
    size: tuple[float, float, float]
    """Length, width and height of that box [m]; the width is the shorter edge seen from above."""
    area: float
    """What it covers, seen from above [m^2]."""
    colour: str
    """The name of its colour; empty where the camera sees none."""
    kind: str = ""
    """What a recogniser takes it for; empty if none was asked, or none knows it."""
    whole: bool
    """Whether the image shows all of it."""
    box: tuple[int, int, int, int]
    """Left, top, right and bottom in the image [px]."""
    floor: float
    """Height of what it stands on, in the world [m]."""
    footprint: Footprint
    around: Footprint = field(repr=False)
    """The same and `REACH` around it."""

    @property
    def position(self) -> Array:
        """(3,) of its middle, in the world [m]."""
        position: Array = self.wTo.translation
        return position

    @property
    def width(self) -> float:
        """Its shorter edge, seen from above [m]."""
        return self.size[1]

    @property
    def name(self) -> str:
        """For messages."""
        return " ".join(word for word in ("the", self.colour, self.kind or "object") if word)

    def __str__(self) -> str:
        """For people: what it is, where, and how wide."""
        x, y, _ = self.position
        return f"{self.name} at {x:.2f}, {y:.2f}, {1000 * self.width:.0f} mm wide"

    def contains(self, points: Array) -> Mask:
        """Which of (N, 3) points of the world [m] belong to it, or are right beside it."""
        return self.around.holds(points[:, 0], points[:, 1])


class DetectedObjects(tuple[DetectedObject, ...]):
    """What stands in a region."""

    __slots__ = ()

    def __str__(self) -> str:
        """For people."""
        return ", ".join(map(str, self)) or "nothing"
