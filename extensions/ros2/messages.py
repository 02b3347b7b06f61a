"""Messages of ROS 2 without ROS: definitions, CDR and type hashes by rosbags, for cyclonedds."""

from collections.abc import Callable
from functools import cache, partial
from importlib.util import find_spec
from typing import Any

import numpy as np

from config import extra

DISTRIBUTION = "ROS2_JAZZY"  # its definitions
_TIME, _UUID, _CLIENT = "builtin_interfaces/Time", "unique_identifier_msgs/UUID", "uint64 client"
_GRIPPER = "control_msgs/action/GripperCommand"
_PARALLEL = "control_msgs/action/ParallelGripperCommand"
_HEAD = f"{_CLIENT}\nint64 number\n"  # of requests and replies, as rmw_cyclonedds has it
_MORE = {
    "nav2_msgs/msg/BehaviorTreeStatusChange": (
        f"{_TIME} timestamp\nstring node_name\nuint16 uid\n"
        "string previous_status\nstring current_status"
    ),
    "nav2_msgs/msg/BehaviorTreeLog": f"{_TIME} timestamp\nBehaviorTreeStatusChange[] event_log",
    "control_msgs/msg/JointJog": (
        "std_msgs/Header header\nstring[] joint_names\nfloat64[] displacements\n"
        "float64[] velocities\nfloat64 duration"
    ),
    "action_msgs/srv/CancelGoal_Request": f"{_HEAD}{_UUID} goal_id\n{_TIME} stamp",
    f"{_GRIPPER}_SendGoal_Request": f"{_HEAD}{_UUID} goal_id\nfloat64 position\nfloat64 max_effort",
    f"{_PARALLEL}_SendGoal_Request": f"{_HEAD}{_UUID} goal_id\nsensor_msgs/JointState command",
    f"{_GRIPPER}_GetResult_Response": (
        f"{_HEAD}int8 status\nfloat64 position\nfloat64 effort\nbool stalled\nbool reached_goal"
    ),
    f"{_PARALLEL}_GetResult_Response": (
        f"{_HEAD}int8 status\nsensor_msgs/JointState state\nbool stalled\nbool reached_goal"
    ),
    **{
        f"{one}_SendGoal_Response": f"{_HEAD}bool accepted\n{_TIME} stamp"
        for one in (_GRIPPER, _PARALLEL)
    },
    **{f"{one}_GetResult_Request": f"{_HEAD}{_UUID} goal_id" for one in (_GRIPPER, _PARALLEL)},
}
"""What rosbags lacks; in actions nested messages are written out, which CDR does not tell apart."""


def missing() -> str:
    """Why ROS 2 cannot be spoken; empty if it can."""
    if find_spec("cyclonedds") is None or find_spec("rosbags") is None:
        return f"the driver of ROS 2 is not installed: {extra('ros2')}"
    return ""


@cache
def store() -> Any:
    """The definitions."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    types = get_typestore(Stores[DISTRIBUTION])
    for name, text in _MORE.items():
        types.register(get_types_from_msg(text, _stored(name)))
    return types


@cache
def _stored(name: str) -> str:
    """Under which the store keeps the parts of actions and services."""
    return name.replace("/action/", "/msg/").replace("/srv/", "/msg/")


@cache
def _fields(name: str) -> dict[str, tuple[str, Callable[[], Any]]]:
    """Of each field the type of the messages in it, empty if it has none, and what makes a zero."""
    return {field: _field(*what) for field, what in store().fielddefs[_stored(name)][1]}


def _field(kind: Any, what: Any) -> tuple[str, Callable[[], Any]]:
    if kind.name == "NAME":
        return what, dict
    if kind.name == "BASE":
        zeros = {"string": str, "bool": bool, "float32": float, "float64": float}
        return "", zeros.get(what[0], int)
    (inner, of), length = what
    if inner.name == "NAME":
        return of, list
    count = length if kind.name == "ARRAY" else 0
    return "", list if of[0] == "string" else partial(np.zeros, count, of[0])


def message(name: str, /, **fields: Any) -> Any:
    """A message of a type, as `sensor_msgs/msg/Image`; fields that are left out are zero or empty.

    Messages in it may be dictionaries.
    """
    values = {
        field: _made(kind, fields[field] if field in fields else zero())
        for field, (kind, zero) in _fields(name).items()
    }
    return store().types[_stored(name)](**values)


def _made(kind: str, value: Any) -> Any:
    if kind and isinstance(value, list):
        return [_made(kind, one) for one in value]
    return message(kind, **value) if isinstance(value, dict) else value


def moment(ns: int) -> Any:
    """A time in messages [ns since 1970]."""
    return message("builtin_interfaces/msg/Time", sec=ns // 10**9, nanosec=ns % 10**9)


def definition(name: str) -> str:
    """The definition of a type and of those in it, as bags have it."""
    return str(store().generate_msgdef(name, ros_version=2)[0])


def encode(name: str, one: Any) -> bytes:
    """CDR of a message, or of its fields."""
    one = _made(name, one)
    return bytes(store().serialize_cdr(one, _stored(name)))


def decode(name: str, data: bytes | bytearray) -> Any:
    """A message from CDR."""
    return store().deserialize_cdr(data, _stored(name))


def type_hash(name: str) -> str:
    """As ROS 2 tells it in discovery since Iron, in the user data of an endpoint."""
    return "" if name in _MORE and "/msg/" not in name else f"typehash={store().hash_rihs01(name)};"


@cache
def dds_type(name: str) -> Any:
    """The type of a message for cyclonedds; of its samples only the CDR is known, `cdr`."""
    from cyclonedds.idl import make_idl_struct

    fields = {field: _dds_field(*what) for field, what in store().fielddefs[_stored(name)][1]}
    package, kind, one = name.split("/")
    made: Any = make_idl_struct(one, f"{package}.{kind}.dds_.{one}_", fields, dataclassify=False)

    def deserialize(data: bytes, **_: Any) -> Any:
        sample = made()
        sample.cdr = data
        return sample

    made.serialize, made.deserialize = lambda sample, **_: sample.cdr, deserialize
    made.deserialize_key = lambda *_, **__: None  # comes when a writer has gone
    return made


def _dds_field(kind: Any, what: Any) -> Any:
    from cyclonedds.idl import types as module

    types: Any = module

    if kind.name == "NAME":
        return dds_type(what)
    if kind.name == "BASE":
        return {"string": str, "bool": bool}.get(what[0]) or getattr(types, what[0])
    inner, length = what
    item = _dds_field(*inner)
    return types.array[item, length] if kind.name == "ARRAY" else types.sequence[item]
