"""Malformed messages of every topic are skipped and named; what is legal and odd is understood.

The parts are the real ones; what is missing is the process that speaks DDS.
"""

import time
from collections.abc import Iterator
from copy import deepcopy
from typing import NamedTuple

import cv2
import numpy as np
import pytest

from extensions.ros2.base_and_arm import ArmOptions, BaseOptions, Ros2Arm, Ros2Base
from extensions.ros2.gripper import GripperOptions, Ros2Gripper
from extensions.ros2.messages import encode, message, missing
from extensions.ros2.sensing import CameraOptions, LaserOptions, Ros2Camera, Ros2Laser
from hw import DriverContext, SimClock
from hw.clock import stopwatch
from robots import load_robot

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())
ROBOT = load_robot("frankie")
NAMES = [f"panda_joint{k}" for k in range(1, 8)]
NAN, INF = float("nan"), float("inf")
NUMBERS = (NAN, -INF, 2e6)
UNIT = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
SIZE = {"width": 640, "height": 480}


def head(frame: str = "") -> dict:
    return {"stamp": {"sec": 100, "nanosec": 1}, "frame_id": frame}


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


def compressed(shape=(480, 640), kind=np.uint16) -> dict:
    png = b"\0" * 12 + cv2.imencode(".png", np.full(shape, 200, kind))[1].tobytes()
    data = np.frombuffer(png, np.uint8)
    return {"header": head(), "format": "16UC1; compressedDepth png", "data": data}


def info() -> dict:
    return {"header": head(), **SIZE, "k": ROBOT.camera.intrinsics.matrix.ravel().copy()}


def ranges() -> dict:
    angles = {"angle_min": -2.0, "angle_max": 2.0, "angle_increment": 0.1}
    numbers = {"range_min": 0.1, "range_max": 20.0, "ranges": np.full(41, 2.0, np.float32)}
    return {"header": head(), **angles, **numbers}


def values(fields: str, *wrong: object, told: str = "") -> list[tuple[str, object, str]]:
    """What fields, or `field[index]`, are set to, and the field that is complained about."""
    return [
        (field, one, told or field.rpartition(".")[2]) for field in fields.split() for one in wrong
    ]


def covariance(at: tuple[int, int], value: float) -> np.ndarray:
    matrix = np.diag([0.01] * 6)
    matrix[at] = value
    return matrix.ravel()


QUATERNIONS = [
    dict(zip("xyzw", map(float, one), strict=True))
    for one in ((0, 0, 0, 0), (1, 1, 1, 1), (NAN, 0, 0, 1), (0, 0.7071, 0, 0.7071))
]
STAMPS = [
    *values("header.stamp.sec", -5, -(2**31), told="header.stamp"),
    *values("header.stamp.nanosec", 2_000_000_000, told="header.stamp"),
]
POSE = [
    *values("pose.pose.position.x pose.pose.position.y", *NUMBERS, told="position"),
    *values("pose.pose.orientation", *QUATERNIONS),
    *STAMPS,
]


JOINTS = [
    *values("position", np.zeros(0)),
    *values("position velocity", np.zeros(3), np.zeros(9)),
    *values("position[2]", *NUMBERS, told="position[panda_joint3]"),
    *values("velocity[2]", -INF, 2e6, told="velocity[panda_joint3]"),
    *values("name", [], ["a"] * 8, [*NAMES[1:], "x", "y"]),
    *values("name", [*NAMES, "finger", "more"], NAMES[:4], told=""),
    *STAMPS,
]
TWIST = [
    *values("twist.twist.linear.x", *NUMBERS, told="twist[linear.x]"),
    *values("twist.twist.linear.y", *NUMBERS, told="twist[linear.y]"),
    *values("twist.twist.angular.z", *NUMBERS, told="twist[angular.z]"),
]
ON_MAP = [
    *values("pose.covariance", *(covariance((5, 5), one) for one in (NAN, -0.01, 1e200))),
    *values("pose.covariance", *(covariance((0, 1), one) for one in (INF, 0.5))),
    *values("header.frame_id", "odom", "", "mapp"),
]
TRANSFORMS = [
    *values("transforms[0].transform.translation.x", *NUMBERS, told="position"),
    *values("transforms[0].transform.translation.y", *NUMBERS, told="position"),
    *values("transforms[0].transform.rotation", *QUATERNIONS, told="orientation"),
    *values("transforms[0].header.frame_id", "", "odom", told="transforms"),
    *values("transforms[0].child_frame_id", "", "map", told="transforms"),
    *values("transforms", []),
]
IMAGE = [
    *values("width height", 0, 240, 2**32 - 1, told="width x height"),
    *values("step", 0, 1279, 2560, 2**32 - 1, told="data"),
    *values("data", *(np.zeros(n, np.uint8) for n in (0, 614399, 614401))),
    *values("encoding", "", "rgb8", "16SC1", "64FC1"),
    *values("encoding", "32FC1", told="data"),
    *STAMPS,
]
COMPRESSED = [
    *values("format", "", "jpeg", "rgb8; png", told="encoding"),
    *values("data", *(np.zeros(n, np.uint8) for n in (0, 12, 500))),
    *values("data", compressed((240, 320))["data"], told="width x height"),
    *values("data", compressed(kind=np.uint8)["data"]),
    *values("data", compressed()["data"][:200], told=""),
    *STAMPS,
]
INFO = [
    *values("k[0] k[2] k[4] k[5]", NAN, 1e256, -1.0),
    *values("k", np.zeros(9), told="k[0]"),
    *values("width", 0, 100, told="k[2]"),
    *values("height", 0, 100, told="k[5]"),
    *STAMPS,
]
SCAN = [
    *values("angle_min angle_max", NAN, INF, 1e30),
    *values("angle_increment", 0.0, NAN, INF, 1.0),
    *values("angle_increment", 0.05, -0.1, told="ranges"),
    *values("range_min", NAN, INF, -1.0),
    *values("range_max", NAN, -INF, 1e30, 0.05),
    *values("ranges", *(np.zeros(n, np.float32) for n in (0, 1, 200))),
    *STAMPS,
]


class Topic(NamedTuple):
    """A topic of a part."""

    part: type
    options: object
    good: dict
    wrong: list
    route: int = 0
    beside: dict[int, dict] = {}  # what comes by other routes  # noqa: RUF012


ARM, GRIPPER = ArmOptions(joints=NAMES), GripperOptions(joint="finger", open=0.04)
AMCL, TF = (BaseOptions(localisation=topic) for topic in ("/amcl_pose", "/tf"))
CAMERA, PNG = CameraOptions(), CameraOptions(depth="camera/compressed", compressed=True)
FINGER = values("position[7]", *NUMBERS, told="position[finger]")
TOPICS = {
    "/joint_states": Topic(Ros2Arm, ARM, joints(), JOINTS),
    "/joint_states of the gripper": Topic(Ros2Gripper, GRIPPER, joints(), FINGER),
    "/odom": Topic(Ros2Base, BaseOptions(), odometry(), TWIST + POSE),
    "/amcl_pose": Topic(Ros2Base, AMCL, on_map(), ON_MAP + POSE, 2, {0: odometry()}),
    "/tf": Topic(Ros2Base, TF, transforms(), TRANSFORMS, 2, {0: odometry()}),
    "/camera/depth/image_rect_raw": Topic(Ros2Camera, CAMERA, image(), IMAGE, 0, {1: info()}),
    "/camera/compressed": Topic(Ros2Camera, PNG, compressed(), COMPRESSED, 0, {1: info()}),
    "/camera/depth/camera_info": Topic(Ros2Camera, CAMERA, info(), INFO, 1, {0: image()}),
    "/scan": Topic(Ros2Laser, LaserOptions(), ranges(), SCAN),
}
RNG = np.random.default_rng(0)
BYTES = [b"", b"\0\1\0\0", b"\xff" * 40, *(RNG.bytes(n) for n in (200, 600, 2600))]


class Stand:
    """A part that hears what is put into its memory, on a clock of its own."""

    def __init__(self, topic: Topic, monkeypatch) -> None:
        self.topic, self.clock, self.seconds = topic, SimClock(), 100
        context = DriverContext(robot=ROBOT, clock=self.clock)
        self.part = topic.part(topic.options, context)
        monkeypatch.setattr(self.part._process, "end_of_it", lambda: "")

    def put(self, route: int, one: bytes) -> None:
        self.part._rings[route].put(stopwatch(), one)

    def hear(self, one: bytes | None, *, ticks: int = 6) -> str:
        """One message again and again, and good ones on the other routes; what is wrong then."""
        told = ""
        for _ in range(ticks):
            self.clock.sleep_until(self.clock.now() + 0.1)
            self.part._status.put(stopwatch(), *[1] * 16)
            self.seconds += 1
            for route, good in self.topic.beside.items():
                self.put(route, self.encoded(good, route))
            if one is not None:
                self.put(self.topic.route, one)
            told = self.trouble()
        return told

    def trouble(self) -> str:
        part = self.part
        if part._state is not None if hasattr(part, "_state") else False:
            return "; ".join(fault.text for fault in part.read().faults)
        return part._trouble() or (part._unlocalised() if isinstance(part, Ros2Base) else "")

    def encoded(self, fields: dict, route: int) -> bytes:
        fields = deepcopy(fields)
        if "header" in fields and fields["header"]["stamp"]["sec"] >= 0:
            fields["header"]["stamp"]["sec"] = self.seconds
        return encode(self.part._routes[route].type, fields)


def changed(good: dict, field: str, value: object, kind: str) -> object:
    """A good message with another value in one field."""
    whole = at = message(kind, **deepcopy(good))
    *path, last = field.replace("[", ".[").split(".")
    for step in path:
        at = at[int(step[1:-1])] if step.startswith("[") else getattr(at, step)
    if last.startswith("["):
        at[int(last[1:-1])] = value
    else:
        inner = getattr(at, last)
        setattr(at, last, type(inner)(**value) if isinstance(value, dict) else value)
    return whole


def cases(topic: Topic, kind: str) -> Iterator[tuple[bytes, str]]:
    """Malformed messages, and what is complained about."""
    for field, value, told in topic.wrong:
        yield encode(kind, changed(topic.good, field, value, kind)), told
    whole = encode(kind, topic.good)
    for one in (*(whole[: len(whole) * k // 13] for k in (1, 5, 9)), *BYTES):
        yield one, ""


@pytest.mark.parametrize("when", ["start", "mid-run"])
@pytest.mark.parametrize("name", TOPICS)
def test_malformed_messages_are_skipped_and_named(name, when, monkeypatch):
    topic = TOPICS[name]
    source = name.partition(" ")[0]
    kind = Stand(topic, monkeypatch).part._routes[topic.route].type
    for wrong, field in cases(topic, kind):
        stand = Stand(topic, monkeypatch)
        if when == "mid-run":
            for _ in range(2):
                stand.seconds += 1
                stand.hear(stand.encoded(topic.good, topic.route), ticks=1)
            assert not stand.trouble()
            assert not stand.part.complaints
        told = stand.hear(wrong)
        is_needed = when == "start" or topic.route == 0
        if is_needed and topic.part is not Ros2Laser:  # which reports no faults
            assert source in told
            assert field in told
        skipped = " ".join(stand.part.complaints)
        if field not in ("", "name", "transforms"):
            assert source in skipped
            assert field in skipped


@pytest.mark.parametrize("velocity", [np.full(8, NAN), np.zeros(0), np.array([NAN] + 7 * [0.0])])
def test_of_a_robot_that_tells_positions_alone_velocities_are_differences(monkeypatch, velocity):
    stand = Stand(TOPICS["/joint_states"], monkeypatch)
    for k in range(2):
        ns = time.time_ns()
        fields = joints() | {"position": np.full(8, 0.1 + 0.02 * k), "velocity": velocity}
        fields["header"]["stamp"] = {"sec": ns // 10**9, "nanosec": ns % 10**9}
        assert stand.hear(encode("sensor_msgs/msg/JointState", fields), ticks=1) == ""
        time.sleep(0.05 * (k == 0))
    qd = stand.part.read().qd
    assert np.ptp(qd) == 0.0
    assert 0.02 < qd[0] < 0.41


@pytest.mark.parametrize("name", ["/joint_states", "/odom", "/scan"])
def test_a_message_without_a_stamp_has_that_of_its_arrival(monkeypatch, name):
    stand = Stand(TOPICS[name], monkeypatch)
    fields = deepcopy(TOPICS[name].good)
    fields["header"]["stamp"] = {"sec": 0, "nanosec": 0}
    for _ in range(5):
        assert stand.hear(encode(stand.part._routes[0].type, fields), ticks=1) == ""
        newest = stand.part.latest() if name == "/scan" else stand.part.read()
        assert stand.clock.now() - newest.stamp < 0.05


def test_joints_of_two_publishers_whose_clocks_differ_are_heard(monkeypatch):
    stand = Stand(TOPICS["/joint_states"], monkeypatch)
    other = joints() | {"name": ["finger"], "position": np.zeros(1), "velocity": np.zeros(1)}
    for k in range(6):
        for fields, ahead in ((other, 600_000_000), (joints(), 0)):
            fields["header"]["stamp"] = {"sec": 100 + k, "nanosec": ahead + 1}
            stand.put(0, encode("sensor_msgs/msg/JointState", fields))
        assert stand.hear(None, ticks=1) == ""


def test_the_old_pose_of_a_latched_topic_is_taken_until_a_new_one_comes(monkeypatch):
    stand = Stand(TOPICS["/amcl_pose"]._replace(route=3), monkeypatch)
    assert stand.hear(stand.encoded(on_map(), 3), ticks=1) == ""
    first = stand.part.read().localised
    stand.put(2, stand.encoded(on_map(), 2))
    newer = stand.part.read().localised
    stand.put(3, stand.encoded(on_map(), 3))
    assert (first is newer, stand.part.read().localised is newer) == (False, True)
    assert newer.source == "/amcl_pose"


def test_a_place_on_the_map_that_is_not_told_is_a_fault_with_its_topic(monkeypatch):
    nothing = TOPICS["/amcl_pose"]
    assert Stand(nothing, monkeypatch).hear(None) == (
        "/amcl_pose has told nothing yet: give the robot its first pose on the map"
    )
    static = Stand(TOPICS["/tf"]._replace(route=3), monkeypatch)
    assert static.hear(static.encoded(transforms(), 3)) == (
        "map -> odom on /tf stands on /tf_static alone, where nothing corrects it"
    )


@pytest.mark.parametrize("is_driving", [True, False])
def test_who_tells_the_place_all_the_time_or_of_a_moving_base_is_missed(monkeypatch, is_driving):
    """AMCL tells nothing of a base that rests."""
    stand, x = Stand(TOPICS["/amcl_pose"], monkeypatch), 0.0
    told = []
    for k in range(80):
        x += 0.05 * is_driving
        good = odometry()
        good["pose"]["pose"]["position"] = {"x": x}
        stand.topic.beside[0] = good
        is_told = k < 40 if is_driving else k < 3
        told.append(stand.hear(stand.encoded(on_map(), 2) if is_told else None, ticks=1))
    if not is_driving:
        assert not any(told)
        return
    assert told.index("/amcl_pose tells nothing any more: look at its node") in range(60, 70)


def test_a_beam_that_meets_nothing_is_told_from_one_that_tells_nothing(monkeypatch):
    stand, told = Stand(TOPICS["/scan"], monkeypatch), ranges()
    told["ranges"][:6] = 0.0, 0.05, 25.0, NAN, -INF, INF
    assert stand.hear(stand.encoded(told, 0)) == ""
    scan = stand.part.latest()
    np.testing.assert_equal(scan.ranges[:7], [NAN] * 5 + [INF, 2.0])
    assert np.array_equal(np.isnan(scan.ranges), np.isnan(scan.points[:, 0]))
