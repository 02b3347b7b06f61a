"""An object of a region as segmented from a depth image."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from config.poses import MapFromOdometry

if TYPE_CHECKING:
    from collections.abc import Callable

    from pinocchio import SE3

    from config.arrays import Array, Mask
    from perception.objects.footprint import Footprint

REACH = 0.008  # grasps and points this far beside an object still belong to it [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class DetectedObject:
    """One object of a region; it is a `Workspace` without the grasps of its neighbours."""

    seen_at: SE3
    """Middle of its box, turned about z only, x along its longer edge from above; as all that
    follows in odometry in which it was seen."""
    size: tuple[float, float, float]
    """Length, width (the shorter edge from above) and height of that box [m]."""
    area: float  # seen from above [m^2]
    colour: str  # name of its colour; empty if the camera has none
    kind: str = ""  # class by a recogniser; empty if not asked or unknown
    whole: bool  # whether the image shows all of it
    box: tuple[int, int, int, int]  # left, top, right and bottom in the image [px]
    floor: float  # height of what it stands on, in odometry [m]
    footprint: Footprint
    around: Footprint = field(repr=False)  # with `REACH` around it
    drift: Callable[[], SE3] | None = field(default=None, repr=False)
    """Where that world is in odometry now, which drifts; None if they are the same."""
    mTo: MapFromOdometry | None = field(default=None, repr=False)
    """Where that world was on the map; None if they are the same."""

    @property
    def position(self) -> Array:
        """(3,) of its middle, in odometry now [m]."""
        here: Array = self.seen_at.translation
        return here if self.drift is None else self.drift().act(here)

    @property
    def width(self) -> float:
        """Its shorter edge, seen from above [m]."""
        return self.size[1]

    @property
    def name(self) -> str:
        """For messages."""
        return " ".join(word for word in ("the", self.colour, self.kind or "object") if word)

    def __str__(self) -> str:
        here = self.seen_at.translation
        x, y, _ = here if self.mTo is None else self.mTo.act(here)
        return f"{self.name} at {x:.2f}, {y:.2f} on the map, {1000 * self.width:.0f} mm wide"

    def contains(self, points: Array) -> Mask:
        """Which of (N, 3) points in odometry now [m] belong to it, or are right beside it."""
        return self._holds(self.around, points)

    def covers(self, points: Array) -> Mask:
        """Which of (N, 3) points in odometry now [m] it covers, seen from above."""
        return self._holds(self.footprint, points)

    def _holds(self, cells: Footprint, points: Array) -> Mask:
        if self.drift is not None:
            then = self.drift().inverse()
            points = points @ then.rotation.T + then.translation
        return cells.holds(points[:, 0], points[:, 1])


class DetectedObjects(tuple[DetectedObject, ...]):
    """The objects of a region."""

    __slots__ = ()

    def __str__(self) -> str:
        return ", ".join(map(str, self)) or "nothing"
