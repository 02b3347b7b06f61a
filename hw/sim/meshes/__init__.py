"""Mesh files: reading, convex decomposition for collisions, simplification for images."""

from hw.sim.meshes.parts import convex_parts
from hw.sim.meshes.reading import MeshError, Units, Up, fewer, read_mesh
