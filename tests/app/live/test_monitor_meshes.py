"""The robot's meshes: made once, kept, and done without."""

import importlib.util

import numpy as np
import pytest

from app.live.monitor import meshes as module
from app.live.monitor.meshes import NAMES, meshes
from app.live.monitor.robot_visual import robot_visual
from robots import load_robot

FRANKIE = load_robot("frankie")
OMNI = load_robot("omni")

needs_assets = pytest.mark.skipif(
    importlib.util.find_spec("rtbdata") is None,
    reason='the meshes need the extra: pip install "frankie-task[assets]"',
)


@pytest.fixture
def no_assets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_EXTRA", ("a_package_that_is_not_there",))


def kinds(bodies: list) -> set[str]:
    return {type(body).__name__ for body in bodies}


@pytest.mark.usefixtures("no_assets")
def test_without_the_extra_the_robot_is_made_of_primitives() -> None:
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
