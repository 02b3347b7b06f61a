"""Convex hulls in the viewer: one mesh with all their faces, where they are."""

import numpy as np
import rerun as rr
from pinocchio import SE3, exp3

from app.live.monitor.solids import solids
from robots import hull_of


def test_hulls_are_drawn_as_one_mesh_in_their_colours():
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05
    red, green = (hull_of(corners, colour=colour) for colour in ((255, 0, 0), (0, 255, 0)))
    away = SE3(exp3(np.array([0.0, 0.0, 0.5])), np.array([1.0, 2.0, 3.0]))
    (mesh,) = solids([red, green.moved(away)])
    assert isinstance(mesh, rr.Mesh3D)
    points = mesh.vertex_positions.as_arrow_array().to_pylist()
    assert len(points) == 2 * 12 * 3
    np.testing.assert_allclose(np.mean(points[36:], axis=0), [1.0, 2.0, 3.0], atol=1e-6)
    normals = np.array(mesh.vertex_normals.as_arrow_array().to_pylist())
    outwards = np.array(points) - np.repeat([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]], 36, axis=0)
    assert (np.einsum("ij,ij->i", normals, outwards) > 0.0).all()
    assert len(set(mesh.vertex_colors.as_arrow_array().to_pylist())) == 2
