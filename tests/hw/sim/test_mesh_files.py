"""Mesh files in scenes: formats, units, convex decomposition, and refusals with a hint."""

from pathlib import Path

import numpy as np
import pytest
from pinocchio import SE3

from hw.sim import DepthRenderer, SceneError, load_scene
from hw.sim.meshes import MeshError, convex_decomposition, convex_parts, fewer, read_mesh
from hw.sim.meshes.shaping import enclosed
from hw.sim.sim_object import Mesh, Surface
from robots import Intrinsics, volume

trimesh = pytest.importorskip("trimesh", reason="needs the extra `meshes`")
pytest.importorskip("vhacdx", reason="needs the extra `meshes`")

GOOD = """\
container: {centre: [3.0, 0.0]}
table: {centre: [0.0, 1.6]}
"""
SIZES = (0.01, 0.6)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def tray() -> trimesh.Trimesh:
    """A hollow box with thick walls, which is not convex."""
    top = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    rings = (
        ([0.05, 0.04], -0.03),
        ([0.05, 0.04], 0.03),
        ([0.04, 0.03], 0.03),
        ([0.04, 0.03], -0.02),
    )
    vertices = np.vstack([np.insert(top * half, 2, z, axis=1) for half, z in rings])
    faces = [[0, 2, 1], [0, 3, 2], [12, 13, 14], [12, 14, 15]]
    for low, high in ((0, 4), (4, 8), (8, 12)):
        for i in range(4):
            j = (i + 1) % 4
            faces += [[low + i, low + j, high + j], [low + i, high + j, high + i]]
    return trimesh.Trimesh(vertices, faces, process=False)


def scene(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mine.yaml"
    path.write_text(GOOD + text)
    return path


def refused(path: Path) -> str:
    with pytest.raises(SceneError) as error:
        load_scene(path, 0, (0.7, 0.5))
    (line,) = str(error.value).splitlines()
    return line


@pytest.mark.parametrize("suffix", ["glb", "obj", "off", "ply", "stl"])
def test_every_format_gives_the_same_body(suffix, tmp_path):
    brick = trimesh.creation.box((0.1, 0.04, 0.06))
    brick.apply_translation([3.0, 2.0, 1.0])
    brick.invert()  # triangles that face inwards are turned
    file = tmp_path / f"brick.{suffix}"
    brick.export(file)
    mesh = read_mesh(str(file), "m", 1.0, "z", SIZES)
    assert mesh.closed
    assert enclosed(mesh.vertices, mesh.triangles) > 0.0
    np.testing.assert_allclose(mesh.half, [0.05, 0.02, 0.03], atol=1e-6)
    (part,) = convex_parts(mesh)
    assert volume(part.shape) == pytest.approx(0.1 * 0.04 * 0.06, rel=1e-5)


def test_units_scale_and_the_default_axis_that_is_up(tmp_path):
    brick = trimesh.creation.box((100.0, 40.0, 60.0))
    for suffix, half in (("stl", (50, 20, 30)), ("glb", (50, 30, 20))):
        brick.export(tmp_path / f"brick.{suffix}")
        mesh = read_mesh(str(tmp_path / f"brick.{suffix}"), "mm", 0.5, None, SIZES)
        np.testing.assert_allclose(mesh.half, 0.0005 * np.array(half), atol=1e-6)


@pytest.mark.parametrize("up", ["x", "-y", "z"])
def test_the_axis_that_is_up_points_upwards(up, tmp_path):
    axis = (-0.05 if up.startswith("-") else 0.05) * np.eye(3)["xyz".index(up[-1])]
    base = 0.02 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    spike = trimesh.convex.convex_hull(np.vstack([base, axis]))
    spike.export(tmp_path / "spike.stl")
    mesh = read_mesh(str(tmp_path / "spike.stl"), "m", 1.0, up, SIZES)
    tip = mesh.vertices[np.linalg.norm(mesh.vertices[:, :2], axis=1).argmin()]
    np.testing.assert_allclose(tip, [0.0, 0.0, 0.035], atol=1e-6)
    assert enclosed(mesh.vertices, mesh.triangles) > 0.0


def test_a_hollow_body_stays_hollow_and_is_split_once(tmp_path, monkeypatch, capsys):
    body = tray()
    assert body.is_watertight
    body.export(tmp_path / "tray.stl")
    mesh = read_mesh(str(tmp_path / "tray.stl"), "m", 1.0, None, SIZES)
    made = convex_parts(mesh, "tray.stl")
    assert capsys.readouterr().err == "tray.stl is cut into convex parts; only this once\n"
    total = sum(volume(part.shape) for part in made)
    assert 0.9 * body.volume < total < 1.25 * body.volume
    assert body.convex_hull.volume > 1.9 * body.volume

    def never(*_: object) -> None:
        raise AssertionError("it is made again")

    monkeypatch.setattr(convex_decomposition, "_split", never)
    again = convex_parts(mesh, "tray.stl")
    assert capsys.readouterr().err == ""
    assert [part.shape.vertices.tolist() for part in again] == [
        part.shape.vertices.tolist() for part in made
    ]


@pytest.mark.slow
def test_a_scan_without_a_bottom_can_be_used(tmp_path):
    scan = trimesh.creation.icosphere(subdivisions=4, radius=0.03)
    scan.update_faces(scan.triangles_center[:, 2] > -0.02)
    scan.vertices += np.random.default_rng(0).normal(scale=1e-4, size=scan.vertices.shape)
    scan.export(tmp_path / "scan.ply")
    mesh = read_mesh(str(tmp_path / "scan.ply"), "m", 1.0, None, SIZES)
    assert not mesh.closed
    whole = 4.0 / 3.0 * np.pi * 0.03**3
    assert 0.8 * whole < sum(volume(part.shape) for part in convex_parts(mesh)) < 1.1 * whole
    drawn = fewer(mesh)
    assert len(drawn.triangles) <= 2500 < len(mesh.triangles)


def test_a_vessel_without_thickness_is_seen_as_solid_as_it_is_touched(tmp_path):
    can = trimesh.creation.cylinder(0.03, 0.1, sections=32)
    can.update_faces(np.abs(can.face_normals[:, 2]) < 0.5)
    can.export(tmp_path / "can.stl")
    mesh = read_mesh(str(tmp_path / "can.stl"), "m", 1.0, None, SIZES)
    assert not mesh.closed
    drawn = fewer(mesh)
    assert drawn.closed
    renderer = DepthRenderer(Intrinsics(width=21, height=21, fx=40.0, fy=40.0, cx=10.0, cy=10.0))
    above = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 0.3]))
    seen = renderer.render([Surface(drawn, SE3.Identity(), "can")], above)
    assert seen[10, 10] == pytest.approx(0.25, abs=1e-3)


@pytest.mark.slow
def test_items_of_a_scene_lie_where_the_file_says(tmp_path):
    tray().export(tmp_path / "tray.stl")
    trimesh.creation.box((40.0, 30.0, 50.0)).export(tmp_path / "brick.obj")
    path = scene(
        tmp_path,
        "objects:\n  items:\n"
        "    - {mesh: tray.stl, mass_g: 123, friction: 0.8, at: [3.1, 0.05], yaw_deg: 90}\n"
        "    - {mesh: brick.obj, units: mm}\n    - {kind: can}\n"
        "fixtures:\n  - {name: statue, mesh: tray.stl, scale: 5, centre: [1, 1, 0.15]}\n"
        "  - {name: heap, mesh: brick.obj, units: cm, centre: [1, -1.5, 0.25], on_map: false}\n",
    )
    world = load_scene(path, 0)
    first = world.objects[0]
    assert [obj.name for obj in world.objects] == ["tray 1", "brick 2", "can 3"]
    assert (first.mass, first.friction) == (0.123, 0.8)
    ways = np.eye(3)
    box = [(first.reach(way), -first.reach(-way)) for way in ways]
    np.testing.assert_allclose(np.ptp(box, axis=1), [0.08, 0.1, 0.06], atol=3e-3)
    np.testing.assert_allclose(np.mean(box, axis=1)[:2], [3.1, 0.05], atol=1e-6)
    assert {world.resting_on(obj) for obj in world.objects} == {"container"}
    assert first.mesh.closed
    assert [f.name for f in world.fixtures if f not in world.mapped] == ["heap"]
    seen = [one.name for one in world.shapes() if isinstance(one, Surface)]
    assert seen == ["statue", "heap", "tray 1", "brick 2"]
    shapes = [one.name for one in world.shapes() if not isinstance(one, Surface)]
    assert not {"statue", "heap", "tray 1", "brick 2"} & set(shapes)


REFUSED = {
    "there is no such file": ("nothing.stl", "there is no file"),
    "it is no mesh at all": ("notes.txt", "`.txt` is no kind of mesh"),
    "it is damaged": ("broken.glb", "cannot be read"),
    "it promises more than there is": ("endless.ply", "cannot be read"),
    "it is flat": ("flat.stl", "it is flat, 0 mm thick"),
    "it is in millimetres": ("large.stl", "possible; are these millimetres? write `units: mm`"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_bad_mesh_is_told_where_and_what(kind, tmp_path):
    name, told = REFUSED[kind]
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "broken.glb").write_bytes(b"glTF\x02\x00\x00\x00" + 100 * b"\xff")
    (tmp_path / "endless.ply").write_text(
        "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000000\nproperty float x\n"
        "property float y\nproperty float z\nelement face 9\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    sheet = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
    sheet.export(tmp_path / "flat.stl")
    trimesh.creation.box((180.0, 60.0, 60.0)).export(tmp_path / "large.stl")
    line = refused(scene(tmp_path, f"objects:\n  items:\n    - {{mass_g: 10, mesh: {name}}}\n"))
    assert line.startswith(f"{tmp_path / 'mine.yaml'}:5:26: objects.items.0.mesh: {name}: ")
    assert told in line
    assert line.isprintable()


def test_a_body_on_the_robot_or_that_cannot_be_split_is_refused(tmp_path, monkeypatch):
    tray().export(tmp_path / "tray.stl")
    monkeypatch.setattr(convex_decomposition, "_PATIENCE", 0.01)
    text = "fixtures:\n  - {name: a, mesh: tray.stl, scale: 9, centre: [0.5, 0, 0.2]}\n"
    assert "it stands where the robot starts" in refused(scene(tmp_path, text))
    line = refused(scene(tmp_path, "objects:\n  items:\n    - {mesh: tray.stl}\n"))
    assert line.startswith(f"{tmp_path / 'mine.yaml'}:5:8: items.0.mesh: it cannot be split into")


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    body = tray()
    monkeypatch.setattr(convex_decomposition, "find_spec", lambda _: None)
    with pytest.raises(MeshError, match=r'pip install "frankie-task\[meshes\]"'):
        convex_parts(Mesh(np.array(body.vertices), body.faces.astype(np.int32)))
