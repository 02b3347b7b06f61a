"""Convex decomposition in a process of its own: `split.py MESH.npz HULLS.npz`."""

import sys


def main(source: str, target: str, most: str, resolution: str) -> None:
    """Read `vertices` and `triangles`; write the corners of hull number i as `i`."""
    import numpy as np
    import vhacdx

    with np.load(source) as mesh:
        vertices, triangles = mesh["vertices"], mesh["triangles"]
    faces = np.column_stack([np.full(len(triangles), 3), triangles])
    hulls = vhacdx.compute_vhacd(
        np.ascontiguousarray(vertices, dtype=np.float64),
        faces.astype(np.uint32).ravel(),
        maxConvexHulls=int(most),
        resolution=int(resolution),
        maxNumVerticesPerCH=48,
    )
    corners = {str(number): np.asarray(points) for number, (points, _) in enumerate(hulls)}
    np.savez(target, **corners)  # type: ignore[arg-type]


if __name__ == "__main__":
    main(*sys.argv[1:])
