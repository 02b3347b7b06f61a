"""Nodes of a tree for viewers; what the viewer can draw of texts, shapes and the robot's meshes."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
import rerun as rr
from pinocchio import SE3, exp3
from sample_run import FAILURE, IDLE, RUNNING, SUCCESS, TREE

from app.live.monitor import meshes as module
from app.live.monitor.glyphs import printable
from app.live.monitor.meshes import NAMES, meshes
from app.live.monitor.robot_visual import robot_visual, solids
from app.live.nodes import NodeInfo, NodeStatus, parents, path_from_root, tip
from robots import hull_of, load_robot


def nodes(*statuses: object) -> list[NodeStatus]:
    return [NodeStatus(status=status, message="") for status in statuses]


def test_safe_text_is_one_line_that_the_font_has() -> None:
    assert printable("Grüße → 90 %, ω ≤ 2 rad/s ✔") == "Grüße → 90 %, ω ≤ 2 rad/s ✔"
    assert printable("two\nlines\t and\x07 a 🤖 ⏱ ✖") == "two lines and□ a □ □ □"
    assert printable("") == ""


def test_parents_and_branch_follow_depth() -> None:
    assert parents(TREE) == (None, 0, 1, 1, 3, 3, 5, 6, 6, 6, 3, 3)
    assert path_from_root(TREE, 9) == (0, 1, 3, 5, 6, 9)
    assert path_from_root(TREE, 0) == (0,)
    assert parents([NodeInfo(name="a", kind="wait", depth=0)]) == (None,)


def test_the_tip_is_where_the_root_got_its_status_from() -> None:
    assert tip(nodes(RUNNING, SUCCESS, RUNNING, IDLE)) == 2
    assert tip(nodes(FAILURE, SUCCESS, FAILURE, FAILURE, IDLE)) == 3
    assert tip(nodes(SUCCESS, FAILURE, SUCCESS)) == 2
    assert tip(nodes(RUNNING, FAILURE, IDLE)) == 0
    assert tip(nodes(IDLE, IDLE, IDLE)) == 0


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


FRANKIE = load_robot("frankie")
OMNI = load_robot("omni")

needs_assets = pytest.mark.skipif(
    importlib.util.find_spec("rtbdata") is None,
    reason='the meshes need the extra: pip install "frankie-task[assets]"',
)


def kinds(bodies: list) -> set[str]:
    return {type(body).__name__ for body in bodies}


def test_without_the_extra_the_robot_is_made_of_primitives(monkeypatch) -> None:
    monkeypatch.setattr(module, "_EXTRA", ("a_package_that_is_not_there",))
    assert meshes() is None
    looks = robot_visual(FRANKIE)
    assert "Boxes3D" in kinds(looks.base)
    assert len(looks.links) == 8
    for bodies in (looks.base, looks.hand, looks.finger, *looks.links):
        assert bodies
        assert "Mesh3D" not in kinds(bodies)


@needs_assets
def test_with_it_every_link_has_its_mesh_and_the_base_where_it_is_known() -> None:
    looks = robot_visual(FRANKIE)
    assert all(kinds(link) == {"Mesh3D"} for link in looks.links)
    assert kinds(looks.base) == kinds(looks.finger) == {"Mesh3D"}
    assert kinds(robot_visual(OMNI).base) == {"Boxes3D"}


@needs_assets
def test_meshes_are_whole_and_have_the_size_of_the_robot() -> None:
    made = meshes()
    assert made is not None
    assert set(made) == set(NAMES)
    assert sum(len(mesh.triangles) for mesh in made.values()) < 60_000
    for mesh in made.values():
        assert mesh.triangles.max() < len(mesh.vertices) == len(mesh.normals) == len(mesh.colours)
        lengths = np.linalg.norm(mesh.normals, axis=1)
        assert np.mean(np.abs(lengths - 1.0) < 1e-3) > 0.998, "but where faces lie back to back"
    size = np.ptp(made["omron"].vertices, axis=0)
    assert size == pytest.approx([*FRANKIE.base.size], abs=0.02)
