"""Objects that can be picked up: rigid bodies of convex parts, with a visual mesh and a motion."""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from pinocchio import SE3

from robots import GREY, Array, Colour, Geom, Triangles, bounding_radius, reach


@dataclass(frozen=True, eq=False)
class Mesh:
    """A visual surface of triangles; collisions use convex parts instead."""

    vertices: Array  # (V, 3) [m]
    triangles: Triangles  # (T, 3) vertex numbers, counter-clockwise as seen from outside
    closed: bool = True  # without holes: the back faces of its triangles are never seen

    @cached_property
    def half(self) -> tuple[float, float, float]:
        """Half edge lengths of the box around it that is centred on its frame [m]."""
        x, y, z = np.abs(self.vertices).max(axis=0).tolist()
        return (x, y, z)


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh with a pose in the world."""

    mesh: Mesh
    pose: SE3
    name: str = ""
    colour: Colour = GREY


Visible: TypeAlias = Geom | Surface


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """Motion along a line, back and forth."""

    start: Array  # (3,) one end of the line, in the world [m]
    along: Array  # (3,) from there to the other end [m]
    period: float  # there and back [s]
    until: float = np.inf  # time from which it stands still [s]
    steady: bool = False  # constant speed; else sinusoidal

    def position(self, now: float) -> Array:
        """(3,) in the world at a time [m]."""
        turns = min(now, self.until) / self.period
        if self.steady:
            share = 1.0 - abs(1.0 - 2.0 * (turns % 1.0))
        else:
            share = 0.5 * (1.0 - float(np.cos(2.0 * np.pi * turns)))
        position: Array = self.start + share * self.along
        return position


@dataclass(kw_only=True, eq=False)
class SimObject:
    """A rigid body; replace `pose` to move it."""

    name: str
    parts: tuple[Geom, ...]  # convex collision shapes, in the object's frame
    mass: float  # [kg], spread over the parts by their volume
    friction: float = 0.5  # Coulomb coefficient with the finger pads
    pose: SE3  # object in the world, wTs; the origin is the centre of mass
    motion: Motion | None = None  # until it is touched
    mesh: Mesh | None = None  # visual, in the object's frame; None: its parts

    @cached_property
    def radius(self) -> float:
        """Radius of a ball around it, centred on its origin [m]."""
        return max(
            float(np.linalg.norm(part.pose.translation)) + bounding_radius(part.shape)
            for part in self.parts
        )

    def placed(self, wTs: SE3 | None = None) -> list[Geom]:
        """Its collision shapes in the world, at its pose or at another one."""
        pose = self.pose if wTs is None else wTs
        return [Geom(p.shape, pose * p.pose, self.name, p.colour) for p in self.parts]

    def visual(self) -> list[Visible]:
        """Its visual shapes in the world."""
        if self.mesh is None:
            return [*self.placed()]
        return [Surface(self.mesh, self.pose, self.name, self.parts[0].colour)]

    def reach(self, direction: Array, wTs: SE3 | None = None) -> float:
        """Its largest coordinate along a unit direction (3,) of the world, at any pose [m]."""
        pose = self.pose if wTs is None else wTs
        along = pose.rotation.T @ direction
        from_origin = max(reach(part, along) for part in self.parts)
        return float(direction @ pose.translation) + from_origin
