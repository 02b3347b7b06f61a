"""What stands around the robot, as far as it is known."""

from __future__ import annotations

from dataclasses import dataclass

from controller.command import Array
from controller.point_cloud import PointCloud
from robots import Geom


@dataclass(frozen=True, eq=False)
class Obstacle:
    """Something that moves, and that must not be hit."""

    geom: Geom
    """Where it is now, in the world."""
    velocity: Array
    """(3,) of its centre, in world axes [m/s]; it does not turn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """What the robot must not hit. The floor is not named: it is always there."""

    fixtures: tuple[Geom, ...] = ()
    """What never moves, in the world. The same object as long as nothing has changed: what is
    computed from it once, such as a map, is kept."""
    moving: tuple[Obstacle, ...] = ()
    """What moves by itself."""
    loose: tuple[Geom, ...] = ()
    """What stands on fixtures and may be carried away, in the world. The links of the arm and the
    camera keep off it. The hand, which works among such things, does not, nor do the base, its way
    and its stance look at it. The same object as long as nothing has changed."""
    depth_points: PointCloud | None = None
    """Points of surfaces that a camera has seen; another one for every frame."""
    held: tuple[Geom, ...] = ()
    """The shapes of what the hand holds, in e: they move with the robot and must not hit anything
    either."""

    def has_shapes_of(self, other: Surroundings) -> bool:
        """Whether the same stands around and is held, wherever what moves by itself is."""
        same = self.held is other.held and self.loose is other.loose
        return same and self.stands_like(other)

    def stands_like(self, other: Surroundings) -> bool:
        """Whether the same stands around that is not loose, wherever what moves by itself is."""
        if self.fixtures is not other.fixtures or len(self.moving) != len(other.moving):
            return False
        both = zip(self.moving, other.moving, strict=True)
        return all(one.geom.shape == before.geom.shape for one, before in both)


OPEN_FLOOR = Surroundings()
"""Nothing around."""
