"""Evaluation of grasps: images, the closed loop, rectangles, pictures, and the commands."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import rerun as rr
from typer.testing import CliRunner

from app.commands import app
from config import ConfigError
from lab.grasps.closed_loop import HELD, empty_container, heldout_container
from lab.grasps.cornell import CAMERA, agree, overlap, read_folder, rectangle
from lab.grasps.images import evaluate_image, evaluation_image
from lab.grasps.recipe import read_recipe
from lab.grasps.scenes import ROBOT
from lab.shared import interval
from perception import GraspDetector
from perception.grasps.table_plane import NoTableError, camera_above_table

RUN = CliRunner()


@pytest.fixture(scope="module")
def detector() -> GraspDetector:
    return GraspDetector(gripper=ROBOT.gripper)


def test_most_grasps_on_heldout_classes_are_valid(detector: GraspDetector) -> None:
    results = [evaluate_image(detector, seed, "single") for seed in range(30)]
    assert sum(each.valid for each in results) >= 25


def test_an_image_is_evaluated_the_same_every_time(detector: GraspDetector) -> None:
    assert evaluate_image(detector, 3, "clutter") == evaluate_image(detector, 3, "clutter")


@pytest.mark.slow
def test_a_container_is_emptied_object_by_object(detector: GraspDetector) -> None:
    world = heldout_container(0)
    objects = len(world.objects)
    picks = empty_container(world, detector, 0)
    assert len(picks) == objects
    assert all(pick.held == (pick.ends[-1] == HELD) for pick in picks)
    assert sum(pick.held for pick in picks) >= objects - 2


def test_the_interval_holds_the_share_and_narrows() -> None:
    few, many = interval([True] * 9 + [False]), interval([True] * 900 + [False] * 100)
    assert few[0] < 0.9 < few[1]
    assert many[1] - many[0] < 0.25 * (few[1] - few[0])
    assert interval([True] * 10)[1] == pytest.approx(1.0)
    # Figures of the textbook example: 10 of 100.
    assert interval([True] * 10 + [False] * 90) == pytest.approx((0.0552, 0.1744), abs=2e-4)


def test_overlap_and_agreement_of_rectangles() -> None:
    one = rectangle(100, 100, 0.3, 40, 20)
    assert overlap(one, one) == pytest.approx(1.0, abs=1e-5)
    half = rectangle(100, 100, 0.3, 20, 20)
    assert overlap(one, half) == pytest.approx(0.5, abs=1e-3)
    assert overlap(one, rectangle(200, 100, 0.3, 40, 20)) == 0.0
    assert agree(one, rectangle(100, 100, 0.3 + np.pi, 40, 20))
    assert agree(one, rectangle(102, 99, 0.7, 40, 20))
    assert not agree(one, rectangle(100, 100, 0.3 + np.radians(31), 40, 20))


def table_seen(tilt: float, block_height: float = 0.0) -> np.ndarray:
    """Depth of a table 0.9 m away along the axis, with a block of a height in the middle [m]."""
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width].astype(float)
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    normal = np.array([0.0, -np.sin(tilt), -np.cos(tilt)])  # of the table, as the camera sees it
    along = 0.9 * normal[2] / (x * normal[0] + y * normal[1] + normal[2])
    depth = along.copy()
    block = (np.abs(u - 330) < 14) & (np.abs(v - 250) < 45)
    depth[block] -= block_height
    return depth.astype(np.float32)


def cornell_folder(folder: Path, cloud: bool) -> Path:
    folder.mkdir()
    depth = table_seen(0.5, 0.04)
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    ray = np.stack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)], -1)
    points = ray * depth[..., None]
    if cloud:
        rows = [
            f"{1e3 * x:.6f} {1e3 * y:.6f} {1e3 * z:.6f} 0 {i}"
            for i, (x, y, z) in enumerate(points.reshape(-1, 3))
            if i % 7
        ]
        text = "# .PCD\nFIELDS x y z rgb index\nDATA ascii\n" + "\n".join(rows) + "\n"
        (folder / "pcd0001.txt").write_text(text)
    else:
        distance = np.linalg.norm(points, axis=2).astype(np.float32)
        cv2.imwrite(str(folder / "pcd0001d.tiff"), distance)
    good = np.concatenate([rectangle(330, v, 0.0, 50, 25) for v in (220, 235, 250, 265, 280)])
    lines = [f"{a:.2f} {b:.2f}" for a, b in good]
    lines += ["NaN NaN", "1 2", "3 4", "5 6"]
    (folder / "pcd0001cpos.txt").write_text("\n".join(lines) + "\n")
    return folder


@pytest.mark.parametrize("cloud", [False, True])
def test_images_in_the_cornell_format_are_read(tmp_path: Path, cloud: bool) -> None:
    (image,) = read_folder(cornell_folder(tmp_path / "01", cloud))
    assert image.name == "pcd0001"
    known = np.isfinite(image.depth)
    assert known.mean() == pytest.approx(6 / 7 if cloud else 1.0, abs=0.01)
    assert image.depth[known] == pytest.approx(table_seen(0.5, 0.04)[known], abs=1e-5)
    assert len(image.rectangles) == 5


def test_a_folder_without_images_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no file pcd\*cpos.txt"):
        list(read_folder(tmp_path))


@pytest.mark.parametrize("tilt", [0.0, 0.4, 0.8])
def test_the_table_tells_where_the_camera_is(tilt: float) -> None:
    wTc = camera_above_table(table_seen(tilt, 0.05), CAMERA)
    assert wTc.translation[2] == pytest.approx(0.9 * np.cos(tilt), abs=1e-3)
    assert wTc.rotation[2, 2] == pytest.approx(-np.cos(tilt), abs=1e-3)
    assert wTc.rotation[:, 0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)


def test_an_image_without_a_table_is_refused() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(NoTableError, match="one plane"):
        camera_above_table(rng.uniform(0.5, 2.0, (480, 640)).astype(np.float32), CAMERA)
    with pytest.raises(NoTableError, match="hardly any depth"):
        camera_above_table(np.full((480, 640), np.nan, dtype=np.float32), CAMERA)


@pytest.mark.parametrize("kind", ["npy", "png"])
def test_grasps_of_ones_own_image_are_shown(tmp_path: Path, kind: str) -> None:
    image = evaluation_image(5, "single")
    depth = np.nan_to_num(image.frame.depth)
    path = tmp_path / f"mine.{kind}"
    if kind == "npy":
        np.save(path, depth)
    else:
        cv2.imwrite(str(path), np.rint(1000 * depth).astype(np.uint16))
    camera = image.frame.intrinsics
    result = RUN.invoke(app, ["grasp", "show", str(path), "--focal", str(camera.fx)])
    assert result.exit_code == 0, result.output
    assert "mm wide" in result.output
    picture = cv2.imread(str(tmp_path / "mine_grasps.png"))
    assert picture.shape[1] == 640
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50


def test_grasps_are_shown_in_a_recording(tmp_path: Path) -> None:
    image = evaluation_image(5, "single")
    depth = np.nan_to_num(image.frame.depth)
    stream = rr.RecordingStream("test")
    stream.save(tmp_path / "mine.rrd")
    for time, metres in ((0.0, np.full_like(depth, 0.7)), (1.0, depth)):
        stream.set_time("t", duration=time)
        stream.log("eye", rr.DepthImage(metres.astype(np.float32), meter=1.0))
    stream.flush()
    stream.disconnect()
    focal = str(image.frame.intrinsics.fx)
    arguments = ["grasp", "show", str(tmp_path / "mine.rrd"), "--focal", focal]
    result = RUN.invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "mm wide" in result.output
    result = RUN.invoke(app, [*arguments, "--at", "0.1"])
    assert "no grasp: " in result.output


PETABYTE = (
    b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, "
    b"'shape': (9999999999999, 22), }".ljust(127)
    + b"\n"
)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("words.rrd", b"hello", "not a recording"),
        ("missing.npy", None, "no such file"),
        ("text.png", b"hello", "not a depth image"),
        ("broken.npy", b"\x93NUMPY garbage", "cannot be read"),
        ("colour.npy", np.zeros((4, 4, 3)), "not a depth image"),
        ("noise.npy", np.random.default_rng(0).uniform(0.5, 2, (240, 320)), "one plane"),
        ("empty.npy", b"", "cannot be read"),
        ("petabyte.npy", PETABYTE, "cannot be read"),
        ("words.npy", np.full((20, 20), "a"), "not a depth image"),
        ("dates.npy", np.zeros((20, 20), "M8[s]"), "not a depth image"),
        ("complex.npy", np.ones((20, 20), complex), "not a depth image"),
        ("truths.npy", np.ones((20, 20), bool), "not a depth image"),
        ("records.npy", np.zeros((20, 20), [("a", float)]), "not a depth image"),
        ("endless.npy", np.full((20, 20), 1e300), "hardly any depth"),
        ("nothing.npy", np.ones((0, 0)), "hardly any depth"),
    ],
)
def test_a_file_without_a_depth_image_is_one_clear_line(
    tmp_path: Path, name: str, content: object, says: str
) -> None:
    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        np.save(path, content)
    result = RUN.invoke(app, ["grasp", "show", str(path)])
    assert result.exit_code == 2
    assert says in result.output
    assert result.output.startswith(str(path))
    assert len(result.output.strip().splitlines()) == 1


def test_the_evaluation_writes_its_figures_and_draws_failures(tmp_path: Path) -> None:
    figures = tmp_path / "e.json"
    folder = cornell_folder(tmp_path / "01", False)
    arguments = ["--images", "6", "--objects", "1", "--workers", "1", "--cornell", str(folder)]
    result = RUN.invoke(
        app,
        ["grasp", "eval", *arguments, "--json", str(figures), "--plot", str(tmp_path / "f.png")],
    )
    assert result.exit_code == 0, result.output
    figures_read = json.loads(figures.read_text())
    assert figures_read["images"] == 6
    for key in ("valid_rate_single", "valid_rate_clutter", "first_attempt_rate"):
        assert 0.0 <= figures_read[key] <= 1.0
    assert figures_read["within_three_rate"] >= figures_read["first_attempt_rate"]
    assert figures_read["cornell_iou_rate"] == 1.0
    assert figures_read["step_median_ms"] > 0.0
    assert "machine" in figures_read


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--network", "resnet"), "`bins`, `ggcnn`"),
        (("--weights", "nowhere.safetensors"), "no such weights file"),
        (("--network", "bins", "--weights", "x"), "give one of the two"),
        (("--cornell", "/nowhere"), "no file pcd*cpos.txt"),
        (("--json", "/nowhere/x.json"), "no folder"),
    ],
)
def test_bad_input_of_the_evaluation(arguments: tuple[str, ...], says: str) -> None:
    result = RUN.invoke(app, ["grasp", "eval", *arguments])
    assert result.exit_code == 2
    assert says in result.output
    assert len(result.output.strip().splitlines()) == 1


def test_recipes_are_checked_with_their_place(tmp_path: Path) -> None:
    assert read_recipe("bins").network == "bins"
    with pytest.raises(ConfigError, match="did you mean `bins`"):
        read_recipe("bin")
    path = tmp_path / "r.yaml"
    path.write_text("network: bins\nlearning: {round: 3}\n")
    with pytest.raises(ConfigError, match=r"r.yaml:2:12: learning.round: unknown key.*`rounds`"):
        read_recipe(str(path))


@pytest.mark.slow
def test_training_from_a_recipe_writes_weights(tmp_path: Path) -> None:
    recipe = tmp_path / "tiny.yaml"
    recipe.write_text(
        "network: bins\ndata: {images: 1, validation_images: 1}\n"
        "learning: {rounds: 2, steps: 2, batch: 2}\n"
    )
    result = RUN.invoke(
        app, ["grasp", "train", str(recipe), "--folder", str(tmp_path / "t"), "--workers", "2"]
    )
    assert result.exit_code == 0, result.output
    weights = tmp_path / "t" / "bins.safetensors"
    assert GraspDetector(weights, gripper=ROBOT.gripper).proposer.name == "bins"
