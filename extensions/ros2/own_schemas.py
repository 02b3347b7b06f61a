"""The messages of a run in Foxglove's own schemas; where it has none, they stay those of ROS 2."""

from collections.abc import Callable
from typing import Any

import foxglove.messages as fox

from extensions.ros2.markers import CUBE, CYLINDER, SPHERE
from extensions.ros2.run_messages import cdr

_Fields = dict[str, Any]

_LEVELS = {20: fox.LogLevel.Info, 30: fox.LogLevel.Warning, 40: fox.LogLevel.Error}
_ENDS = {"bottom_scale": 1.0, "top_scale": 1.0}
_PRIMITIVES: dict[int, tuple[str, Any, _Fields]] = {
    CUBE: ("cubes", fox.CubePrimitive, {}),
    SPHERE: ("spheres", fox.SpherePrimitive, {}),
    CYLINDER: ("cylinders", fox.CylinderPrimitive, _ENDS),
}


def encode(topic: str, fields: _Fields) -> bytes:
    """Protobuf of the fields of a ROS 2 message, or CDR where there is no schema."""
    if topic not in _PROTOBUF:
        return cdr(topic, fields)
    kind, made = _PROTOBUF[topic]
    return bytes(kind(**made(fields)).encode())


def _when(header: _Fields) -> fox.Timestamp:
    return fox.Timestamp(header["stamp"].sec, header["stamp"].nanosec)


def _head(header: _Fields) -> _Fields:
    return {"timestamp": _when(header), "frame_id": header["frame_id"]}


def _pose(pose: _Fields) -> fox.Pose:
    position, turn = fox.Vector3(**pose["position"]), fox.Quaternion(**pose["orientation"])
    return fox.Pose(position=position, orientation=turn)


def _joints(fields: _Fields) -> _Fields:
    rows = zip(fields["name"], fields["position"], fields["velocity"], strict=True)
    joints = [fox.JointState(name=name, position=q, velocity=qd) for name, q, qd in rows]
    return {"timestamp": _when(fields["header"]), "joints": joints}


def _transform(one: _Fields) -> fox.FrameTransform:
    return fox.FrameTransform(
        timestamp=_when(one["header"]),
        parent_frame_id=one["header"]["frame_id"],
        child_frame_id=one["child_frame_id"],
        translation=fox.Vector3(**one["transform"]["translation"]),
        rotation=fox.Quaternion(**one["transform"]["rotation"]),
    )


def _odometry(fields: _Fields) -> _Fields:
    speeds = {f"{name}_velocity": fox.Vector3(**v) for name, v in fields["twist"]["twist"].items()}
    body, pose = fields["child_frame_id"], _pose(fields["pose"]["pose"])
    return _head(fields["header"]) | {"body_frame_id": body, "pose": pose} | speeds


def _pictured(fields: _Fields) -> _Fields:
    """Of an image, or of the model of its camera."""
    named = {name.upper() if len(name) == 1 else name: value for name, value in fields.items()}
    if "data" in named:
        named["data"] = named["data"].tobytes()
    return _head(named.pop("header")) | named


def _logged(fields: _Fields) -> _Fields:
    told = {"name": fields["name"], "message": fields["msg"], "level": _LEVELS[fields["level"]]}
    return {"timestamp": _when(fields)} | told


def _entity(marker: _Fields) -> fox.SceneEntity:
    same: _Fields = {"pose": _pose(marker["pose"]), "color": fox.Color(**marker["color"])}
    if corners := [fox.Point3(**one) for one in marker["points"]]:
        shape: _Fields = {"triangles": [fox.TriangleListPrimitive(points=corners, **same)]}
    else:
        name, kind, more = _PRIMITIVES[marker["type"]]
        shape = {name: [kind(size=fox.Vector3(**marker["scale"]), **same, **more)]}
    frame, number = marker["header"]["frame_id"], f"{marker['ns']} {marker['id']}"
    return fox.SceneEntity(frame_id=frame, id=number, frame_locked=True, **shape)


_PROTOBUF: dict[str, tuple[Any, Callable[[_Fields], _Fields]]] = {
    "/joint_states": (fox.JointStates, _joints),
    "/tf": (fox.FrameTransforms, lambda f: {"transforms": [*map(_transform, f["transforms"])]}),
    "/odom": (fox.Odometry, _odometry),
    "/goal_pose": (fox.PoseInFrame, lambda f: _head(f["header"]) | {"pose": _pose(f["pose"])}),
    "/plan": (
        fox.PosesInFrame,
        lambda f: _head(f["header"]) | {"poses": [_pose(one["pose"]) for one in f["poses"]]},
    ),
    "/camera/depth/image_rect_raw": (fox.RawImage, _pictured),
    "/camera/depth/camera_info": (fox.CameraCalibration, _pictured),
    "/rosout": (fox.Log, _logged),
    "/scene": (fox.SceneUpdate, lambda f: {"entities": [*map(_entity, f["markers"])]}),
}
SCHEMAS = {topic: kind.get_schema() for topic, (kind, _) in _PROTOBUF.items()}
"""Foxglove's schemas, by topic."""
