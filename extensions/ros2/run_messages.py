"""What a run shows as ROS 2 messages: topics, types and rates, for files and for live viewers.

Frames are those of REP 105, and of the Panda's URDF where the arm is one.
"""

from collections.abc import Callable, Iterator
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from pinocchio import SE3

from app.live import (
    Changes,
    Look,
    SceneView,
    ShownRun,
    Snapshot,
    Throttle,
    arm_parts,
    base_parts,
    finger_poses,
    hand_parts,
    looks,
)
from config.planar import Pose2D
from controller import RobotModel, se3_of
from extensions.ros2.markers import markers, posed, rotation, xyz
from extensions.ros2.messages import encode, moment
from hw import DepthFrame

Schemas: TypeAlias = Literal["ros2", "foxglove"]
"""Definitions of messages in MCAP files: those of ROS 2, or Foxglove's own."""

TOPICS = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/odom": "nav_msgs/msg/Odometry",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/goal_pose": "geometry_msgs/msg/PoseStamped",
    "/plan": "nav_msgs/msg/Path",
    "/camera/depth/image_rect_raw": "sensor_msgs/msg/Image",
    "/camera/depth/camera_info": "sensor_msgs/msg/CameraInfo",
    "/behavior_tree_log": "nav2_msgs/msg/BehaviorTreeLog",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/rosout": "rcl_interfaces/msg/Log",
    "/scene": "visualization_msgs/msg/MarkerArray",
}
"""The type of each topic."""

_POSE_PERIOD = 0.04  # shortest time between two messages of poses [s],
_IMAGE_PERIOD = 0.2  # of two images,
_STATUS_PERIOD = 1.0  # of transforms and diagnostics that have not changed,
_SCENE_PERIOD = 5.0  # and of the shapes
_LEVELS = {"info": 20, "warning": 30, "error": 40}  # of rcl_interfaces/Log
_OK, _WARN, _ERROR = range(3)  # of diagnostic_msgs/DiagnosticStatus
_CAMERA = "camera_depth_optical_frame"


class Message(NamedTuple):
    """One message of a topic."""

    topic: str
    time: int  # [ns since 1970]
    data: bytes


def cdr(topic: str, fields: Any) -> bytes:
    """The fields of a message as ROS 2 has them."""
    return encode(TOPICS[topic], fields)


class Messages:
    """Turns the snapshots of one run, in order, into messages, whose fields `encoded` encodes."""

    def __init__(self, run: ShownRun, encoded: Callable[[str, Any], bytes] = cdr) -> None:
        self._encoded = encoded
        robot, tree, scene = run.robot, run.tree, run.scene
        self._robot, self._model = robot, RobotModel(robot)
        self._tree, self._began = tree, run.began
        brand = f"{robot.arm.visual}_" if robot.arm.visual else ""
        count = len(robot.arm.joints)
        self._joints = [*robot.arm.names] or [f"{brand}joint{i + 1}" for i in range(count)]
        self._joints += [f"{brand}finger_joint{i}" for i in (1, 2)]
        self._links = [f"{brand}link{i}" for i in range(count + 1)]
        self._hand, self._tool = f"{brand}hand", f"{brand}hand_tcp"
        self._fingers = f"{brand}leftfinger", f"{brand}rightfinger"
        ours = {"map", "odom", "base_link", _CAMERA, *self._links, self._hand, self._tool}
        named = ((one.strip("/"), pose) for one, pose in robot.arm.links)
        self._urdf = [(k, *one) for k, one in enumerate(named) if one[0] not in ours]
        self._objects = [f"object/{name}" for name, _ in scene.objects]
        self._scene = self._shapes(scene)
        self._changes = Changes(tree)
        self._statuses = ["IDLE"] * len(tree)
        self._nodes: object = None
        self._way: object = None
        self._sent: dict[str, SE3] = {}  # newest transforms, by child
        self._poses, self._images = Throttle(_POSE_PERIOD), Throttle(_IMAGE_PERIOD)
        self._diagnostics, self._scenes = Throttle(_STATUS_PERIOD), Throttle(_SCENE_PERIOD)
        self._at_rest = Throttle(_STATUS_PERIOD)

    def of(self, seen: Snapshot) -> Iterator[Message]:
        """The messages of the next snapshot."""
        now = self._began + round(seen.stamp * 1e9)
        for topic, fields in self._contents(seen, moment(now)):
            yield Message(topic, now, self._encoded(topic, fields))
        if self._scenes.due(seen.stamp):
            yield Message("/scene", now, self._scene)
        if (frame := seen.frame) is not None and self._images.due(frame.stamp):
            captured = self._began + round(frame.stamp * 1e9)
            for topic, fields in _picture(frame, moment(captured)):
                yield Message(topic, captured, self._encoded(topic, fields))

    def _contents(self, seen: Snapshot, now: Any) -> Iterator[tuple[str, Any]]:
        """Topics and fields of the messages but pictures and shapes."""
        state, on_map = seen.state, {"stamp": now, "frame_id": "map"}
        joints = {
            "header": {"stamp": now},
            "name": self._joints,
            "position": np.array([*state.q, *[state.gripper_width / 2.0] * 2]),
            "velocity": np.array([*state.qd, np.nan, np.nan]),
        }
        yield "/joint_states", joints
        if self._poses.due(seen.stamp):
            odometry = {
                "header": {"stamp": now, "frame_id": "odom"},
                "child_frame_id": "base_link",
                "pose": {"pose": posed(state.oTb)},
                "twist": {"twist": _twist(state.base_twist)},
            }
            yield "/odom", odometry
            on_base = {"stamp": now, "frame_id": "base_link"}
            yield "/cmd_vel", {"header": on_base, "twist": _twist(seen.command.base_twist)}
            transforms = [
                {
                    "header": {"stamp": now, "frame_id": parent},
                    "child_frame_id": child,
                    "transform": {"translation": xyz(pose.translation), "rotation": rotation(pose)},
                }
                for parent, child, pose in self._moved(seen)
            ]
            yield "/tf", {"transforms": transforms}
            base = None if seen.base_goal is None else se3_of(seen.base_goal)
            if (goal := seen.hand_goal or base) is not None:
                yield "/goal_pose", {"header": on_map, "pose": posed(goal)}
        if seen.way is not None and seen.way is not self._way:
            self._way = seen.way
            poses = [
                {"header": on_map, "pose": posed(se3_of(Pose2D(*one)))} for one in seen.way.tolist()
            ]
            yield "/plan", {"header": on_map, "poses": poses}
        yield from self._told(seen, now)

    def _moved(self, seen: Snapshot) -> Iterator[tuple[str, str, SE3]]:
        """The transforms that have changed; once a second all of them."""
        everything = self._at_rest.due(seen.stamp)
        for parent, child, pose in self._transforms(seen):
            if everything or not pose.isApprox(self._sent[child], 1e-6):
                self._sent[child] = pose
                yield parent, child, pose

    def _transforms(self, seen: Snapshot) -> Iterator[tuple[str, str, SE3]]:
        """Parent, child and pose of the child, from the map to camera, fingers and objects."""
        oTb, gripper = seen.state.oTb, self._robot.gripper
        yield "map", "odom", seen.mTo
        yield "odom", "base_link", oTb
        names = ["base_link", *self._links, self._hand]
        poses = [oTb, *self._model.link_poses(oTb, seen.state.q)]
        for i in range(1, len(names)):
            yield names[i - 1], names[i], poses[i - 1].actInv(poses[i])
        fingers = finger_poses(gripper, seen.state.gripper_width)
        for name, pose in zip(self._fingers, fingers, strict=True):
            yield self._hand, name, pose
        yield self._hand, self._tool, gripper.hTe
        yield self._tool, _CAMERA, self._robot.camera.eTc
        for link, name, pose in self._urdf:
            yield self._links[link], name, pose
        for name, pose in zip(self._objects, seen.objects, strict=True):
            yield "map", name, pose

    def _told(self, seen: Snapshot, now: Any) -> Iterator[tuple[str, Any]]:
        """Transitions of nodes, lines of the log, and the state of robot and tree."""
        words = self._statuses
        if seen.nodes != self._nodes:
            self._nodes = seen.nodes
            words = [one.status.value.replace("INVALID", "IDLE") for one in seen.nodes]
        changes = [
            {
                "timestamp": now,
                "node_name": self._tree[index].name,
                "uid": index,
                "previous_status": before,
                "current_status": after,
            }
            for index, (before, after) in enumerate(zip(self._statuses, words, strict=True))
            if before != after
        ]
        self._statuses = words
        if changes:
            yield "/behavior_tree_log", {"timestamp": now, "event_log": changes}
        lines = self._changes.of(seen)
        for line in lines:
            log = {"stamp": now, "level": _LEVELS[line.severity], "name": "frankie_task"}
            yield "/rosout", log | {"msg": line.text}
        if self._diagnostics.due(seen.stamp) or changes or lines:
            faults = "; ".join(fault.text for fault in seen.state.faults)
            status = [_status("robot", _ERROR if faults else _OK, faults or "no fault")]
            levels = {Look.NOT_YET: _WARN, Look.FAILURE: _ERROR}
            for i, look in enumerate(looks(self._tree, seen.nodes)):
                text = f"{words[i]} {seen.nodes[i].message}".strip()
                status.append(_status(f"tree: {self._tree[i].name}", levels.get(look, _OK), text))
            yield "/diagnostics", {"header": {"stamp": now}, "status": status}

    def _shapes(self, scene: SceneView) -> bytes:
        """Robot, furniture and objects."""
        robot, gripper = self._robot, self._robot.gripper
        bodies = {
            "base_link": base_parts(robot.base),
            **dict(zip(self._links, arm_parts(robot.arm), strict=True)),
            self._hand: hand_parts(robot),
            **dict.fromkeys(self._fingers, (gripper.finger, gripper.pad)),
        }
        found = [one for frame, parts in bodies.items() for one in markers("robot", frame, parts)]
        found += markers("furniture", "map", scene.fixtures)
        for frame, (_, parts) in zip(self._objects, scene.objects, strict=True):
            found += markers("objects", frame, parts)
        return self._encoded("/scene", {"markers": [m | {"id": i} for i, m in enumerate(found)]})


def _picture(frame: DepthFrame, now: Any) -> Iterator[tuple[str, Any]]:
    """The depth image as REP 118 has it, and the model of its camera."""
    lens = frame.intrinsics
    head = {"stamp": now, "frame_id": _CAMERA}
    size = {"header": head, "height": lens.height, "width": lens.width}
    pixels = np.frombuffer(frame.depth.astype("<f4").tobytes(), np.uint8)
    image = {"encoding": "32FC1", "step": 4 * lens.width, "data": pixels}
    yield "/camera/depth/image_rect_raw", size | image
    p = np.column_stack([lens.matrix, np.zeros(3)]).ravel()
    model = {"k": lens.matrix.ravel(), "r": np.eye(3).ravel(), "p": p, "d": np.zeros(5)}
    yield "/camera/depth/camera_info", size | model | {"distortion_model": "plumb_bob"}


def _twist(twist: Any) -> dict[str, Any]:
    vx, vy, turn = twist
    return {"linear": xyz((vx, vy, 0.0)), "angular": xyz((0.0, 0.0, turn))}


def _status(name: str, level: int, text: str) -> dict[str, Any]:
    return {"level": level, "name": name, "message": text, "hardware_id": "frankie_task"}
