"""Mesh files: reading, convex decomposition for collisions, simplification for images."""

from hw.sim.meshes.convex_decomposition import convex_parts
from hw.sim.meshes.mesh_file import MeshError, Units, Up, fewer, read_mesh
