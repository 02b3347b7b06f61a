"""ROS 2 messages without ROS: from dictionaries to CDR, and their definitions."""

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

_STORE = get_typestore(Stores.ROS2_JAZZY)
_NAV2 = {
    "nav2_msgs/msg/BehaviorTreeStatusChange": (
        "builtin_interfaces/Time timestamp\nstring node_name\nuint16 uid\n"
        "string previous_status\nstring current_status\n"
    ),
    "nav2_msgs/msg/BehaviorTreeLog": (
        "builtin_interfaces/Time timestamp\nBehaviorTreeStatusChange[] event_log\n"
    ),
}
for _kind, _definition in _NAV2.items():
    _STORE.register(get_types_from_msg(_definition, _kind))


class _Field(NamedTuple):
    name: str
    kind: str  # the type of the messages in it; empty if it has none
    zero: Any


def cdr(kind: str, fields: Mapping[str, Any]) -> bytes:
    """A message of a type, as `sensor_msgs/msg/Image`; fields that are left out are zero.

    Messages in it are dictionaries too, or made by `moment`.
    """
    return bytes(_STORE.serialize_cdr(_built(kind, fields), kind))


def moment(ns: int) -> Any:
    """A time in messages [ns since 1970]."""
    return _built("builtin_interfaces/msg/Time", {"sec": ns // 10**9, "nanosec": ns % 10**9})


def definition(kind: str) -> str:
    """The definition of a type and of those in it, as bags have it."""
    return _STORE.generate_msgdef(kind, ros_version=2)[0]


def _built(kind: str, fields: Mapping[str, Any]) -> Any:
    values = {}
    for name, inner, zero in _fields(kind):
        value = fields.get(name, zero)
        if inner and isinstance(value, dict):
            value = _built(inner, value)
        elif inner and isinstance(value, list):
            value = [_built(inner, one) for one in value]
        values[name] = value
    return _STORE.types[kind](**values)


@cache
def _fields(kind: str) -> tuple[_Field, ...]:
    return tuple(_field(name, *what) for name, what in _STORE.fielddefs[kind][1])


def _field(name: str, node: Nodetype, what: Any) -> _Field:
    if node is Nodetype.NAME:
        return _Field(name, what, _built(what, {}))
    if node is Nodetype.BASE:
        zeros = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}
        return _Field(name, "", zeros.get(what[0], 0))
    (inner, of), count = what
    if inner is Nodetype.NAME:
        return _Field(name, of, [])
    return _Field(name, "", [] if of[0] == "string" else np.zeros(count, of[0]))
