"""Things that can be picked up: rigid bodies made of a few primitives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pinocchio import SE3

from hw.sim.shapes import Array, Placed, bounding_radius, reach


@dataclass(kw_only=True, eq=False)
class SimObject:
    """A rigid body; replace `pose` to move it."""

    name: str
    parts: tuple[Placed, ...]
    """Its convex parts, posed in the object's own frame."""
    mass: float
    """[kg]."""
    friction: float = 0.5
    """Coulomb friction coefficient with the finger pads."""
    pose: SE3
    """Object in the world, wTo; the origin is the centre of mass."""

    @cached_property
    def radius(self) -> float:
        """Radius of a ball around it, centred on its origin [m]."""
        return max(
            float(np.linalg.norm(part.pose.translation)) + bounding_radius(part.shape)
            for part in self.parts
        )

    def placed(self, wTo: SE3 | None = None) -> list[Placed]:
        """Its parts in the world, named after it; as if it were at `wTo` when that is given."""
        pose = self.pose if wTo is None else wTo
        return [Placed(p.shape, pose * p.pose, self.name, p.colour) for p in self.parts]

    def reach(self, direction: Array) -> float:
        """How far it reaches along a unit direction (3,) of the world [m]."""
        along = self.pose.rotation.T @ direction
        from_origin = max(reach(part, along) for part in self.parts)
        return float(direction @ self.pose.translation) + from_origin
