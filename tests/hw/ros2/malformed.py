"""Messages of every topic that a robot in ROS 2 tells, and what may be wrong with them."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from hw.ros2 import (
    ArmOptions,
    BaseOptions,
    CameraOptions,
    GripperOptions,
    LaserOptions,
    Ros2Arm,
    Ros2Base,
    Ros2Camera,
    Ros2Gripper,
    Ros2Laser,
)
from robots import load_robot

ROBOT = load_robot("frankie")
NAMES = [f"panda_joint{k}" for k in range(1, 8)]
NAN, INF = float("nan"), float("inf")
NUMBERS = (NAN, INF, -INF, 1e256, -1e256, 2e6, -1e9)
UNIT = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
MATRIX = ROBOT.camera.intrinsics.matrix.ravel()
SIZE = {"width": 640, "height": 480}


def head(frame: str = "", seconds: int = 100) -> dict:
    return {"stamp": {"sec": seconds, "nanosec": 1}, "frame_id": frame}


def joints() -> dict:
    numbers = {"position": np.full(8, 0.1), "velocity": np.zeros(8)}
    return {"header": head(), "name": [*NAMES, "finger"], **numbers}


def odometry() -> dict:
    return {"header": head("odom"), "pose": {"pose": {"orientation": UNIT}}}


def on_map() -> dict:
    told = {"pose": {"orientation": UNIT}, "covariance": np.diag([0.01] * 6).ravel()}
    return {"header": head("map"), "pose": told}


def transforms() -> dict:
    moved = {"rotation": UNIT}
    return {"transforms": [{"header": head("map"), "child_frame_id": "odom", "transform": moved}]}


def image() -> dict:
    data = np.full(480 * 640, 700, "<u2").view(np.uint8)
    return {"header": head(), **SIZE, "encoding": "16UC1", "step": 1280, "data": data}


def compressed(shape=(480, 640)) -> dict:
    png = b"\0" * 12 + cv2.imencode(".png", np.full(shape, 700, np.uint16))[1].tobytes()
    data = np.frombuffer(png, np.uint8)
    return {"header": head(), "format": "16UC1; compressedDepth png", "data": data}


def info() -> dict:
    return {"header": head(), **SIZE, "k": MATRIX.copy()}


def ranges() -> dict:
    angles = {"angle_min": -2.0, "angle_max": 2.0, "angle_increment": 0.1}
    numbers = {"range_min": 0.1, "range_max": 20.0, "ranges": np.full(41, 2.0, np.float32)}
    return {"header": head(), **angles, **numbers}


def values(field: str, *wrong: object, told: str = "") -> list[tuple[str, object, str]]:
    """What a field, or `field[index]`, is set to, and the field that is complained about."""
    return [(field, one, told or field.rpartition(".")[2]) for one in wrong]


def stamps(there: str = "header") -> list:
    wrong = [("sec", -5), ("nanosec", 2_000_000_000), ("nanosec", 4_294_967_295), ("sec", -(2**31))]
    return [(f"{there}.stamp.{field}", value, "header.stamp") for field, value in wrong]


def turns(field: str) -> list:
    quaternions = [(0, 0, 0, 0), (0, 0, 0, 2), (0, 0, 0, 1e-9), (1, 1, 1, 1), (NAN, 0, 0, 1)]
    quaternions += [(0, 0, INF, 1), (0, 0, 0, -INF), (1, 0, 0, 0), (0, 0.7071, 0, 0.7071)]
    made = [dict(zip("xyzw", map(float, one), strict=True)) for one in quaternions]
    return values(field, *made, told="orientation")


def of_joint(index: int, name: str) -> list:
    short = [np.zeros(0), np.zeros(3), np.zeros(7), np.zeros(9)]
    return [
        *values("position", *short),
        *values("velocity", *short[1:]),
        *values(f"position[{index}]", *NUMBERS, told=f"position[{name}]"),
        *values(f"velocity[{index}]", *NUMBERS[1:], told=f"velocity[{name}]"),
        *values("name", [], ["a"] * 8, [*NAMES[1:], "x", "y"], [""] * 8, told="name"),
        *values("name", [*NAMES, "finger", "more"], NAMES[:4], told=""),
        *stamps(),
    ]


def negative(row: int, column: int, value: float) -> np.ndarray:
    matrix = np.diag([0.01] * 6)
    matrix[row, column] = value
    return matrix.ravel()


COVARIANCES = [
    *(negative(k, k, value) for k in (0, 1, 5) for value in (NAN, INF, -0.01, -1e9, 1e200)),
    *(negative(*at, value) for at in ((0, 1), (1, 5)) for value in (NAN, 0.5)),
    np.full(36, NAN),
    np.full(36, -1.0),
]
MOVED = "transforms[0]"
SHIFT = f"{MOVED}.transform.translation"


class Topic(NamedTuple):
    """A topic of a part."""

    part: type
    options: object
    route: int
    good: dict
    wrong: list
    beside: dict[int, dict] = {}  # what comes by other routes  # noqa: RUF012


ARM = ArmOptions(joints=NAMES)
AMCL, TF = BaseOptions(localisation="/amcl_pose"), BaseOptions(localisation="/tf")
PLACE = [f"pose.pose.position.{axis}" for axis in "xy"]
TOPICS = {
    "/joint_states": Topic(Ros2Arm, ARM, 0, joints(), of_joint(2, "panda_joint3")),
    "/joint_states of the gripper": Topic(
        Ros2Gripper,
        GripperOptions(joint="finger", open=0.04),
        0,
        joints(),
        [one for one in of_joint(7, "finger") if one[0] != "name"],
    ),
    "/odom": Topic(
        Ros2Base,
        BaseOptions(),
        0,
        odometry(),
        [
            *(one for field in PLACE for one in values(field, *NUMBERS, told="position")),
            *(
                one
                for field in ("linear.x", "linear.y", "angular.z")
                for one in values(f"twist.twist.{field}", *NUMBERS, told=f"twist[{field}]")
            ),
            *turns("pose.pose.orientation"),
            *stamps(),
        ],
    ),
    "/amcl_pose": Topic(
        Ros2Base,
        AMCL,
        2,
        on_map(),
        [
            *(one for field in PLACE for one in values(field, *NUMBERS, told="position")),
            *values("pose.covariance", *COVARIANCES),
            *values("header.frame_id", "odom", "", "base_link", "mapp"),
            *turns("pose.pose.orientation"),
            *stamps(),
        ],
        {0: odometry()},
    ),
    "/tf": Topic(
        Ros2Base,
        TF,
        2,
        transforms(),
        [
            *(
                one
                for axis in "xy"
                for one in values(
                    f"{MOVED}.transform.translation.{axis}", *NUMBERS, told="position"
                )
            ),
            *turns(f"{MOVED}.transform.rotation"),
            *values(f"{MOVED}.header.frame_id", "", "odom", "world", told="transforms"),
            *values(f"{MOVED}.child_frame_id", "", "odom_combined", "map", told="transforms"),
            *values("transforms", [], told="transforms"),
        ],
        {0: odometry()},
    ),
    "/camera/depth/image_rect_raw": Topic(
        Ros2Camera,
        CameraOptions(),
        0,
        image(),
        [
            *values("width", 0, 320, 641, 2**32 - 1, told="width x height"),
            *values("height", 0, 240, 481, 2**32 - 1, told="width x height"),
            *values("step", 0, 1279, 1281, 2560, 2**32 - 1, told="data"),
            *values("data", *(np.zeros(n, np.uint8) for n in (0, 1, 614399, 614401))),
            *values("encoding", "", "rgb8", "16SC1", "64FC1", "mono8", "32FC3", "depth", "bayer"),
            *values("encoding", "32FC1", told="data"),
            *stamps(),
        ],
        {1: info()},
    ),
    "/camera/depth/compressed": Topic(
        Ros2Camera,
        CameraOptions(depth="camera/depth/compressed", compressed=True),
        0,
        compressed(),
        [
            *values("format", "", "png", "jpeg", "rgb8; png", told="encoding"),
            *values("data", *(np.zeros(n, np.uint8) for n in (0, 5, 12, 13, 500)), told=""),
            *values("data", compressed((240, 320))["data"], told="width x height"),
            *values("data", compressed()["data"][:200], told=""),
            *stamps(),
        ],
        {1: info()},
    ),
    "/camera/depth/camera_info": Topic(
        Ros2Camera,
        CameraOptions(),
        1,
        info(),
        [
            *(
                one
                for index in (0, 2, 4, 5)
                for one in values(f"k[{index}]", NAN, INF, 1e256, -1.0, told=f"k[{index}]")
            ),
            *values("k", np.zeros(9), np.full(9, NAN), told="k[0]"),
            *values("width", 0, 100, told="k[2]"),
            *values("height", 0, 100, told="k[5]"),
            *stamps(),
        ],
        {0: image()},
    ),
    "/scan": Topic(
        Ros2Laser,
        LaserOptions(),
        0,
        ranges(),
        [
            *values("angle_min", NAN, INF, -INF, 1e30, -7.0),
            *values("angle_max", NAN, INF, 1e30, told="angle_max"),
            *values("angle_increment", 0.0, NAN, INF, 1e30, 1.0, told="angle_increment"),
            *values("angle_increment", 0.05, -0.1, told="ranges"),
            *values("range_min", NAN, INF, -1.0, 1e30),
            *values("range_max", NAN, -INF, -1.0, 1e30, 0.05),
            *values("ranges", *(np.zeros(n, np.float32) for n in (0, 1, 20, 200))),
            *stamps(),
        ],
    ),
}
RNG = np.random.default_rng(0)
BYTES = [b"", b"\0", b"\0\1\0\0", b"\xff" * 40, *(RNG.bytes(200 * k) for k in range(1, 14))]
