"""Things that can be picked up: rigid bodies made of a few primitives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pinocchio import SE3

from robots.shapes import Array, Geom, bounding_radius, reach


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """How an object moves by itself: along a line to its end and back, again and again."""

    start: Array
    """(3,) where it begins, in the world [m]."""
    along: Array
    """(3,) from there to the other end [m]."""
    period: float
    """Time for the way there and back [s]."""
    until: float = np.inf
    """From then on it stands still [s]."""

    def position(self, now: float) -> Array:
        """(3,) where it is at a time, in the world [m]; it turns round smoothly."""
        phase = 2.0 * np.pi * min(now, self.until) / self.period
        position: Array = self.start + 0.5 * (1.0 - np.cos(phase)) * self.along
        return position


@dataclass(kw_only=True, eq=False)
class SimObject:
    """A rigid body; replace `pose` to move it."""

    name: str
    parts: tuple[Geom, ...]
    """Its convex parts, posed in the object's own frame."""
    mass: float
    """[kg]."""
    friction: float = 0.5
    """Coulomb friction coefficient with the finger pads."""
    pose: SE3
    """Object in the world, wTo; the origin is the centre of mass."""
    motion: Motion | None = None
    """How it moves as long as nobody has touched it."""

    @cached_property
    def radius(self) -> float:
        """Radius of a ball around it, centred on its origin [m]."""
        return max(
            float(np.linalg.norm(part.pose.translation)) + bounding_radius(part.shape)
            for part in self.parts
        )

    def placed(self, wTo: SE3 | None = None) -> list[Geom]:
        """Its parts in the world, named after it; as if it were at `wTo` when that is given."""
        pose = self.pose if wTo is None else wTo
        return [Geom(p.shape, pose * p.pose, self.name, p.colour) for p in self.parts]

    def reach(self, direction: Array) -> float:
        """How far it reaches along a unit direction (3,) of the world [m]."""
        along = self.pose.rotation.T @ direction
        from_origin = max(reach(part, along) for part in self.parts)
        return float(direction @ self.pose.translation) + from_origin
