"""`grasp show`: grasps in images and recordings, the pose of the table, and damaged files."""

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
import rerun as rr
import trimesh
from command_line import call
from mcap_ros2.writer import Writer
from pinocchio import SE3
from rosbags.typesys import Stores, get_typestore

from hw.sim import DepthRenderer
from lab.grasps.depth_files import load_depth_file
from lab.grasps.scenes import FLOOR, HELDOUT_CLASSES, ROBOT, random_world
from lab.grasps.show import NoTableError, camera_above_table

CAMERA = ROBOT.camera.intrinsics


def table_depth(tilt: float) -> np.ndarray:
    """Depth of a table 0.9 m away along the axis, with a block of 50 mm in the middle [m]."""
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width].astype(float)
    x, y = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    normal = np.array([0.0, -np.sin(tilt), -np.cos(tilt)])  # of the table, as the camera sees it
    depth = 0.9 * normal[2] / (x * normal[0] + y * normal[1] + normal[2])
    depth[(np.abs(u - 330) < 14) & (np.abs(v - 250) < 45)] -= 0.05
    return depth.astype(np.float32)


@pytest.fixture(scope="module")
def depth() -> np.ndarray:
    """One object seen from above; 0 where nothing was measured."""
    world, _ = random_world(np.random.default_rng(5), HELDOUT_CLASSES, 1)
    x, y, _ = world.objects[0].pose.translation
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), np.array([x, y, FLOOR + 0.4]))
    return np.nan_to_num(DepthRenderer(CAMERA).render(world.shapes(), wTc))


@pytest.mark.parametrize("tilt", [0.0, 0.8])
def test_the_table_tells_where_the_camera_is(tilt: float) -> None:
    wTc = camera_above_table(table_depth(tilt), CAMERA)
    assert wTc.translation[2] == pytest.approx(0.9 * np.cos(tilt), abs=1e-3)
    assert wTc.rotation[2, 2] == pytest.approx(-np.cos(tilt), abs=1e-3)
    assert wTc.rotation[:, 0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)


def test_a_wall_is_no_table() -> None:
    with pytest.raises(NoTableError, match="a wall"):
        camera_above_table(table_depth(1.4), CAMERA)


def test_grasps_in_an_image_are_drawn(tmp_path: Path, depth: np.ndarray) -> None:
    path = tmp_path / "mine.png"
    cv2.imwrite(str(path), np.rint(1000 * depth).astype(np.uint16))
    code, out, err = call("grasp", "show", path, "--focal", CAMERA.fx)
    assert code == 0, err
    assert "mm wide" in out
    picture = cv2.imread(str(tmp_path / "mine_grasps.png"))
    assert picture.shape[1] == 640
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50


def test_a_point_cloud_is_a_depth_image_too(tmp_path: Path, depth: np.ndarray) -> None:
    v, u = np.nonzero(depth)
    z = depth[v, u]
    points = np.stack([(u - CAMERA.cx) / CAMERA.fx * z, (v - CAMERA.cy) / CAMERA.fy * z, z], axis=1)
    trimesh.PointCloud(points * [1, -1, -1]).export(tmp_path / "viewer.ply")
    head = f"VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS {len(z)}\n"
    binary = points.astype("<f4").tobytes()
    (tmp_path / "binary.pcd").write_bytes(f"{head}DATA binary\n".encode() + binary)
    text = "\n".join(" ".join(map(str, row)) for row in points.astype("f4"))
    (tmp_path / "text.pcd").write_text(f"{head}DATA ascii\n{text}\n")
    code, out, err = call("grasp", "show", tmp_path / "viewer.ply")
    assert code == 0, err
    assert "mm wide" in out
    shown = [load_depth_file(tmp_path / name) for name in ("viewer.ply", "binary.pcd", "text.pcd")]
    for one in shown:
        assert np.nanmedian(one.depth) == pytest.approx(np.median(z), abs=1e-3)
        assert one.intrinsics.fx == pytest.approx(CAMERA.fx, rel=0.03)


def test_neither_scale_nor_focal_length_is_guessed_silently(tmp_path, depth) -> None:
    np.save(tmp_path / "mm.npy", 1000 * depth)
    code, _, err = call("grasp", "show", tmp_path / "mm.npy")
    assert (code, "--scale" in err) == (2, True)
    info = tmp_path / "info.yaml"
    info.write_text(f"height: 480\nK: [{CAMERA.fx}, 0, 319.5, 0, {CAMERA.fy}, 239.5, 0, 0, 1]\n")
    arguments = ("grasp", "show", tmp_path / "mm.npy", "--scale", 0.001)
    assert "focal length of a D435" in call(*arguments)[1]
    code, out, err = call(*arguments, "--camera", info)
    assert ("mm wide" in out, "D435" in out) == (True, False), err
    info.write_text("height: 720\nfx: 1\nfy: 1\ncx: 0\ncy: 0\n")
    assert "720 rows" in call(*arguments, "--camera", info)[2]


def test_grasps_in_a_recording_are_shown(tmp_path: Path, depth: np.ndarray) -> None:
    stream = rr.RecordingStream("test")
    stream.save(tmp_path / "mine.rrd")
    for time, metres in ((0.0, np.full_like(depth, 0.7)), (1.0, depth)):
        stream.set_time("t", duration=time)
        png = cv2.imencode(".png", np.rint(1000.0 * metres).astype(np.uint16))[1].tobytes()
        image = rr.EncodedDepthImage(png, media_type="image/png", meter=1000.0)
        stream.log("world/camera/depth", image)
    stream.flush()
    stream.disconnect()
    arguments = ("grasp", "show", tmp_path / "mine.rrd", "--focal", CAMERA.fx)
    assert "mm wide" in call(*arguments)[1]
    assert "no grasp: " in call(*arguments, "--at", 0.1)[1]


def bag(path: Path, depth: np.ndarray, encoding: str) -> None:
    """The bag of another library: one depth image behind one of a colour camera."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    millimetres = np.rint(1000.0 * depth).astype(np.uint16)
    height, width = depth.shape
    head = {"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "eye"}}
    size = head | {"height": height, "width": width}
    kind, kept = "sensor_msgs/msg/Image", millimetres
    if encoding == "32FC1":
        kept = depth.astype(np.float32)
    image = size | {"encoding": encoding, "step": kept.itemsize * width, "data": kept.tobytes()}
    if "compressedDepth" in encoding:
        kind, a, b = "sensor_msgs/msg/CompressedImage", 1e4, -1.0
        png = (
            millimetres
            if "16UC1" in encoding
            else np.where(depth > 0.0, a / np.maximum(depth, 0.1) + b, 0.0)
        )
        pixels = cv2.imencode(".png", png.astype(np.uint16))[1].tobytes()
        image = head | {"format": encoding, "data": struct.pack("<iff", 0, a, b) + pixels}
    colour = size | {"encoding": "rgb8", "step": 3 * width, "data": bytes(3 * depth.size)}
    k = (CAMERA.fx, 0.0, CAMERA.cx, 0.0, CAMERA.fy, CAMERA.cy, 0.0, 0.0, 1.0)
    info, image_kind = {"k": k, "distortion_model": "plumb_bob"}, "sensor_msgs/msg/Image"
    with path.open("wb") as file, Writer(file) as writer:
        for topic, name, content in (
            ("/rgb/image", image_kind, colour),
            ("/rgb/camera_info", "sensor_msgs/msg/CameraInfo", size | info | {"k": (1.0,) * 9}),
            ("/depth/camera_info", "sensor_msgs/msg/CameraInfo", size | info),
            ("/depth/image", kind, image),
        ):
            schema = writer.register_msgdef(name, store.generate_msgdef(name, ros_version=2)[0])
            writer.write_message(topic, schema, content, log_time=10**9, publish_time=10**9)


@pytest.mark.parametrize(
    "encoding", ["16UC1", "32FC1", "16UC1; compressedDepth png", "32FC1; compressedDepth png"]
)
def test_anybodys_bag_gives_depth_and_camera(tmp_path, depth, encoding):
    bag(tmp_path / "mine.mcap", depth, encoding)
    found = load_depth_file(tmp_path / "mine.mcap")
    known = depth > 0.0
    np.testing.assert_allclose(found.depth[known], depth[known], atol=1.1e-3)
    assert (found.intrinsics, found.assumed) == (CAMERA, "")


PETABYTE = (
    b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, "
    b"'shape': (9999999999999, 22), }".ljust(127)
    + b"\n"
)


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("words.rrd", b"hello", "not a recording"),
        ("words.mcap", b"hello", "cannot be read"),
        ("missing.npy", None, "no such file"),
        ("text.png", b"hello", "not a depth image"),
        ("petabyte.npy", PETABYTE, "cannot be read"),
        ("colour.npy", np.zeros((4, 4, 3)), "not a depth image"),
        ("words.npy", np.full((20, 20), "a"), "not a depth image"),
        ("noise.npy", np.random.default_rng(0).uniform(0.5, 2, (240, 320)), "one plane"),
        ("endless.npy", np.full((20, 20), 1e300), "hardly any depth"),
    ],
)
def test_a_file_without_a_depth_image_is_one_clear_line(tmp_path, name, content, says):
    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        np.save(path, content)
    code, _, err = call("grasp", "show", path)
    assert code == 2
    assert says in err
    assert err.startswith(str(path))
    assert len(err.splitlines()) == 1
