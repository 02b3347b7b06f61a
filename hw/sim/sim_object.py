"""Objects that can be picked up: rigid bodies made of a few convex parts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pinocchio import SE3

from hw.sim.surface import Mesh, Surface, Visible
from robots import Array, Geom, bounding_radius, reach


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """How an object moves by itself: back and forth along a line."""

    start: Array  # (3,) one end of the line, in the world [m]
    along: Array  # (3,) from there to the other end [m]
    period: float  # Time from one end to the other and back [s]
    until: float = np.inf  # Time from which it stands still [s]
    steady: bool = False  # Whether it is always as fast; else it turns round smoothly

    def position(self, now: float) -> Array:
        """(3,) its position in the world at a time [m]."""
        turns = min(now, self.until) / self.period
        share = 1.0 - abs(1.0 - 2.0 * (turns % 1.0)) if self.steady else _smoothly(turns)
        position: Array = self.start + share * self.along
        return position


def _smoothly(turns: float) -> float:
    """Share of the way after so many ways there and back."""
    return 0.5 * (1.0 - float(np.cos(2.0 * np.pi * turns)))


@dataclass(kw_only=True, eq=False)
class SimObject:
    """A rigid body; replace `pose` to move it."""

    name: str
    parts: tuple[Geom, ...]
    """Its convex parts, posed in the object's own frame. What touches it touches them."""
    mass: float  # [kg]; spread over the parts by their volume
    friction: float = 0.5  # Coulomb friction coefficient with the finger pads
    pose: SE3  # Object in the world, wTo; the origin is the centre of mass
    motion: Motion | None = None  # How it moves until it is touched
    mesh: Mesh | None = None
    """What a camera sees of it, in the object's own frame; None if that is its parts."""

    @cached_property
    def radius(self) -> float:
        """Radius of a ball around it, centred on its origin [m]."""
        return max(
            float(np.linalg.norm(part.pose.translation)) + bounding_radius(part.shape)
            for part in self.parts
        )

    def placed(self, wTo: SE3 | None = None) -> list[Geom]:
        """Its parts in the world, named after it, at its pose or at another one."""
        pose = self.pose if wTo is None else wTo
        return [Geom(p.shape, pose * p.pose, self.name, p.colour) for p in self.parts]

    def seen(self) -> list[Visible]:
        """What a camera sees of it, in the world."""
        if self.mesh is None:
            return [*self.placed()]
        return [Surface(self.mesh, self.pose, self.name, self.parts[0].colour)]

    def reach(self, direction: Array, wTo: SE3 | None = None) -> float:
        """Its largest coordinate along a unit direction (3,) of the world, at any pose [m]."""
        pose = self.pose if wTo is None else wTo
        along = pose.rotation.T @ direction
        from_origin = max(reach(part, along) for part in self.parts)
        return float(direction @ pose.translation) + from_origin
