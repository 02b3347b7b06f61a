"""Mesh files: reading, convex decomposition for collisions, simplification for images."""

from hw.sim.meshes.parts import convex_parts
from hw.sim.meshes.reading import MeshError, Units, Up, fewer, read_mesh

__all__ = ["MeshError", "Units", "Up", "convex_parts", "fewer", "read_mesh"]
