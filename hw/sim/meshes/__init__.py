"""Bodies of any shape, from files of triangles: what a camera sees, and what touches.

`read_mesh` reads and checks a file, `convex_parts` makes hulls of it, `fewer` is what is drawn.
"""

from hw.sim.meshes.parts import convex_parts
from hw.sim.meshes.reading import MeshError, Units, Up, fewer, read_mesh

__all__ = ["MeshError", "Units", "Up", "convex_parts", "fewer", "read_mesh"]
