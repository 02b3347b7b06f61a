"""Triangle meshes, as a camera sees them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from pinocchio import SE3

from robots import GREY, Array, Colour, Geom, Triangles


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface of triangles. It is seen and not felt: bodies touch by their convex parts."""

    vertices: Array  # (V, 3) corners [m]
    triangles: Triangles  # (T, 3) numbers of the corners, counter-clockwise as seen from outside
    closed: bool = True
    """Whether it has no holes: then the inner sides of its triangles are never seen."""

    @cached_property
    def half(self) -> tuple[float, float, float]:
        """Half edge lengths of the box around it that is centred on its frame [m]."""
        x, y, z = np.abs(self.vertices).max(axis=0).tolist()
        return (x, y, z)


@dataclass(frozen=True, eq=False)
class Surface:
    """A mesh with a pose."""

    mesh: Mesh
    pose: SE3  # In the world
    name: str = ""
    colour: Colour = GREY


Visible: TypeAlias = Geom | Surface  # Something that a camera sees
