"""Mesh processing: welding, closing holes, simplification, components, volume."""

import numpy as np
import numpy.typing as npt

from config.arrays import Indices
from robots import Array, Triangles

_WELD = 1e-6  # distance of merged corners, relative to the bounding box
_MOST_LOST = 0.05  # share of the surface that simplifying may remove


def welded(vertices: Array, triangles: Triangles) -> tuple[Array, Triangles]:
    """The same triangles with shared vertices, without degenerate ones."""
    cell = max(float(np.ptp(vertices, axis=0).max()) * _WELD, 1e-12)
    _, first, of = np.unique(
        np.round(vertices / cell), axis=0, return_index=True, return_inverse=True
    )
    joined = of.ravel()[triangles]
    a, b, c = joined.T
    joined = joined[(a != b) & (b != c) & (c != a)]
    _, once = np.unique(np.sort(joined, axis=1), axis=0, return_index=True)
    used, flat = np.unique(joined[np.sort(once)], return_inverse=True)
    return vertices[first[used]], flat.reshape(-1, 3).astype(np.int32)


def simplified(vertices: Array, triangles: Triangles, most: int) -> tuple[Array, Triangles]:
    """About `most` triangles by quadric error metrics; more where a part would vanish otherwise."""
    if len(triangles) <= most:
        return vertices, triangles
    import fast_simplification

    low, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max())
    unit = ((vertices - low) / size).astype(np.float32)
    area = _area(vertices, triangles)
    for target in (most, 2 * most, 4 * most):
        if target >= len(triangles):
            return vertices, triangles
        corners, fewer = fast_simplification.simplify(unit, triangles, target_count=target)
        found = welded(low + size * corners.astype(np.float64), fewer.astype(np.int32))
        if len(found[1]) and abs(_area(*found) / area - 1.0) < _MOST_LOST:
            return found
    return found


def is_closed(vertices: Array, triangles: Triangles) -> bool:
    """Whether every edge belongs to two triangles, in opposite directions."""
    from trimesh import Trimesh

    mesh = Trimesh(vertices, triangles, process=False)
    return bool(mesh.is_watertight and mesh.is_winding_consistent)


def enclosed(vertices: Array, triangles: Triangles) -> float:
    """Volume of closed triangles, negative if they are seen from inside [m³]."""
    from trimesh import Trimesh

    return float(Trimesh(vertices - vertices.mean(axis=0), triangles, process=False).volume)


def with_holes_filled(vertices: Array, triangles: Triangles) -> tuple[Array, Triangles]:
    """Close every hole by a fan around its middle, of any orientation."""
    rim = _lone(triangles)
    if not len(rim):
        return vertices, triangles
    hole = _connected(rim, len(vertices))[rim[:, 0]]
    holes, which = np.unique(hole, return_inverse=True)
    middles = np.array(
        [vertices[rim[which == number]].mean((0, 1)) for number in range(len(holes))]
    )
    fans = np.column_stack([rim[:, ::-1], len(vertices) + which])
    return np.concatenate([vertices, middles]), np.concatenate([triangles, fans]).astype(np.int32)


def components(vertices: Array, triangles: Triangles) -> list[tuple[Array, Triangles]]:
    """The bodies that share no vertex."""
    edges = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    body = _connected(edges, len(vertices))[triangles[:, 0]]
    found = []
    for number in np.unique(body):
        used, flat = np.unique(triangles[body == number], return_inverse=True)
        found.append((vertices[used], flat.reshape(-1, 3).astype(np.int32)))
    return found


def _area(vertices: Array, triangles: Triangles) -> float:
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


def _lone(triangles: Triangles) -> Indices:
    """(E, 2) edges of only one triangle."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, first, count = np.unique(
        np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True
    )
    lone: Indices = edges[first[count == 1]].astype(np.int64)
    return lone


def _connected(edges: npt.NDArray[np.integer], count: int) -> npt.NDArray[np.int32]:
    """(count,) component number of each vertex."""
    from scipy.sparse import coo_matrix  # slow to import
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(edges), dtype=bool)
    graph = coo_matrix((ones, (edges[:, 0], edges[:, 1])), shape=(count, count))
    labels: npt.NDArray[np.int32] = connected_components(graph, directed=False)[1]
    return labels
