"""A really recorded run as MCAP, read back by libraries that did not write it."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_ros2.decoder import DecoderFactory
from pinocchio import SE3, Quaternion
from pinocchio.utils import rotate
from rosbags.highlevel import AnyReader

from app.core import RunOptions, run_task
from app.live.viewer.viewer import converted
from app.review import chunks, depth_images
from controller import RobotModel
from extensions.ros2.bag import export_mcap
from extensions.ros2.run_messages import TOPICS
from robots import load_robot

CAMERA = "/camera/depth"
TASK = """\
task: look
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
regions: {floor: {centre: [0.7, 0.0, 0.3], size: [0.4, 0.4, 0.6]}}
tree:
  sequence:
    - navigate: {to: near}
    - {force: success, grasp: {within: floor, patience_s: 1.0}}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    root = tmp_path_factory.mktemp("recorded")
    (root / "look.yaml").write_text(TASK)
    # Poor, so that odometry and map differ.
    chosen = {"scene": "single", "localisation": "poor", "record": root}
    return run_task(RunOptions(tree=root / "look.yaml", **chosen)).folder


@pytest.fixture(scope="module")
def bag(run) -> Path:
    code, said, _ = call("mcap", run, run / "run.mcap")
    assert (code, "run.mcap" in said) == (0, True)
    return run / "run.mcap"


@pytest.fixture(scope="module")
def read(bag):
    """Messages by topic, as decoded from the definitions in the file."""
    with bag.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        found = {}
        for schema, channel, _, message in reader.iter_decoded_messages():
            kind = (schema.encoding, channel.message_encoding, schema.name)
            assert kind == ("ros2msg", "cdr", TOPICS[channel.topic])
            found.setdefault(channel.topic, []).append(message)
    return found


def pose_of(place, turn):
    turned = Quaternion(np.array([turn.x, turn.y, turn.z, turn.w]))
    return SE3(turned, np.array([place.x, place.y, place.z]))


def seconds(stamp):
    return stamp.sec % 100_000 + 1e-9 * stamp.nanosec


def test_every_reading_is_there_at_its_time(run, bag, read):
    states, joints = np.load(run / "states.npy"), read["/joint_states"]
    assert [message.name[:2] for message in joints[:1]] == [["panda_joint1", "panda_joint2"]]
    np.testing.assert_array_equal([m.position[:7] for m in joints], states[:, 7:14])
    np.testing.assert_array_equal([m.velocity[:7] for m in joints], states[:, 14:21])
    times = np.array([seconds(m.header.stamp) for m in joints])
    np.testing.assert_allclose(times - times[0], states[:, 0] - states[0, 0], atol=1e-6)
    with AnyReader([bag]) as other:
        counts = {topic: info.msgcount for topic, info in other.topics.items()}
    assert counts == {topic: len(some) for topic, some in read.items()}
    assert set(TOPICS) == set(counts)


def test_transforms_lead_from_the_map_to_the_hand_that_the_joints_give(run, read):
    states, model = np.load(run / "states.npy"), RobotModel(load_robot("frankie"))
    parents, poses, tilted = {}, {}, 0.0
    for tick, message in zip(range(0, len(states), 4), read["/tf"], strict=True):
        for one in message.transforms:
            parents[one.child_frame_id] = one.header.frame_id
            poses[one.child_frame_id] = pose_of(one.transform.translation, one.transform.rotation)
        frame, found = "panda_hand_tcp", SE3.Identity()
        while frame != "odom":
            frame, found = parents[frame], poses[frame] * found
        x, y, heading = states[tick, 1:4]
        oTb = SE3(rotate("z", heading), np.array([x, y, 0.0]))
        assert found.isApprox(oTb * model.bTe(states[tick, 7:14]), 1e-5)
        tilted = max(tilted, float(np.linalg.norm(poses["odom"].translation)))
    assert tilted > 1e-3
    assert parents["camera_depth_optical_frame"] == "panda_hand_tcp"


def test_images_are_those_of_the_recording(run, read):
    images = list(depth_images(run / "recording.rrd"))
    assert len(images) > 1
    told = zip(read[f"{CAMERA}/image_rect_raw"], read[f"{CAMERA}/camera_info"], images, strict=True)
    for message, info, (_, depth) in told:
        assert message.encoding == "32FC1"
        assert seconds(message.header.stamp) == seconds(info.header.stamp)
        pixels = np.frombuffer(message.data, "<f4").reshape(message.height, message.width)
        np.testing.assert_array_equal(np.nan_to_num(pixels), depth)
        assert info.k[2] == pytest.approx(message.width / 2, abs=1.0)


def test_transitions_are_those_of_the_log(run, read):
    events = [json.loads(line) for line in (run / "events.jsonl").read_text().splitlines()]
    logged = [(e["node"], e["status"]) for e in events if e["event"] == "node"]
    told = [one for message in read["/behavior_tree_log"] for one in message.event_log]
    found = [(one.uid, one.current_status.replace("IDLE", "INVALID")) for one in told]
    assert sorted(found) == sorted(logged)
    assert any("grasp" in line.msg for line in read["/rosout"])
    tree = [one for one in read["/diagnostics"][-1].status if one.name.startswith("tree")]
    assert (tree[0].level, tree[0].message.split()[0]) == (0, "SUCCESS")


def test_the_scene_hangs_on_frames_that_are_told(read):
    markers = read["/scene"][0].markers
    known = {one.child_frame_id for message in read["/tf"] for one in message.transforms}
    assert {one.header.frame_id for one in markers} <= known | {"map"}
    assert {one.ns for one in markers} == {"robot", "furniture", "objects"}
    assert len({one.id for one in markers}) == len(markers)


FOXGLOVE = {
    **{"/joint_states": "JointStates", "/tf": "FrameTransforms", "/odom": "Odometry"},
    **{"/goal_pose": "PoseInFrame", "/plan": "PosesInFrame", "/scene": "SceneUpdate"},
    **{f"{CAMERA}/image_rect_raw": "RawImage", f"{CAMERA}/camera_info": "CameraCalibration"},
    "/rosout": "Log",
}


def test_the_same_run_in_the_schemas_of_foxglove(run, bag, read, tmp_path):
    assert call("mcap", run, tmp_path / "own.mcap", "--schemas", "foxglove")[0] == 0
    own, names, times, theirs = {}, {}, {}, {}
    with bag.open("rb") as file, (tmp_path / "own.mcap").open("rb") as mine:
        for _, channel, one in make_reader(file).iter_messages():
            theirs.setdefault(channel.topic, []).append(one.log_time)
        reader = make_reader(mine, decoder_factories=[ProtobufFactory(), DecoderFactory()])
        for schema, channel, one, message in reader.iter_decoded_messages():
            names[channel.topic] = schema.name
            times.setdefault(channel.topic, []).append(one.log_time)
            own.setdefault(channel.topic, []).append(message)
    assert times == theirs
    assert names == TOPICS | {topic: f"foxglove.{kind}" for topic, kind in FOXGLOVE.items()}
    states = np.load(run / "states.npy")
    ticks = [one.timestamp.ToNanoseconds() for one in own["/joint_states"]]
    assert ticks == times["/joint_states"]
    np.testing.assert_allclose(np.subtract(ticks, ticks[0]) / 1e9, states[:, 0], atol=1e-6)
    joints = [[joint.position for joint in one.joints[:7]] for one in own["/joint_states"]]
    np.testing.assert_array_equal(joints, states[:, 7:14])
    for one, other in zip(own["/tf"], read["/tf"], strict=True):
        for found, told in zip(one.transforms, other.transforms, strict=True):
            assert found.parent_frame_id == told.header.frame_id
            pose = pose_of(told.transform.translation, told.transform.rotation)
            assert pose_of(found.translation, found.rotation).isApprox(pose)
    image, info = f"{CAMERA}/image_rect_raw", f"{CAMERA}/camera_info"
    assert [one.data for one in own[image]] == [bytes(one.data) for one in read[image]]
    assert list(own[info][0].K) == list(read[info][0].k)
    assert len(own["/scene"][0].entities) == len(read["/scene"][0].markers)
    assert [one.message for one in own["/rosout"]] == [one.msg for one in read["/rosout"]]
    assert own["/diagnostics"][-1].status[0].message == "no fault"


def test_rerun_makes_a_recording_of_it_and_it_is_not_overwritten(run, bag, tmp_path):
    made = converted(bag, tmp_path / "made.rrd")
    entities = {chunk.entity_path for chunk in chunks(made, "/**")}
    assert entities >= {"/tf", f"{CAMERA}/image_rect_raw", "/joint_states/position", "/rosout"}
    with pytest.raises(Exception, match=r"run.mcap: cannot be written .*name a new file"):
        export_mcap(run, bag)
