"""Counterparts in BehaviorTree.CPP: tags and attributes of words, ports of values and leaves.

`{name}` in an attribute stands for an entry of the blackboard.
"""

import re
from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from behaviours import BasePose, Posture, Region, ToolPose
from config import Plain, parse_scalar
from config.arrays import Array
from config.planar import yaw_of
from trees.language import (
    COMPOSITES,
    MODIFIERS,
    PARAMETER_TYPES,
    Counterpart,
    KeyRead,
    LeafType,
    NamedValue,
    TaskParameter,
    ValueType,
)

MAIN = "Main"  # the tree that runs the exported task with its default parameters

SUBTREE = "SubTree"
SCRIPT = "Script"  # writes keys: the language's `set`

PARALLEL = "Parallel"  # the one node whose attributes count its children; see `parallel_counts`

SWITCHES = range(2, 7)  # how many cases a `Switch` of BehaviorTree.CPP may have

VALUE = "value"  # the port of an exported modifier that BehaviorTree.CPP does not have

_FORCED = map(MODIFIERS["force"].of, ("success", "failure"))
_WORDS = (*COMPOSITES.values(), *MODIFIERS.values(), *_FORCED)
_TAGS = {word.counterpart.tag for word in _WORDS if word.counterpart is not None}
_SWITCH_TAGS = {f"Switch{number}" for number in SWITCHES} | {"AlwaysFailure"}

TAKEN = frozenset({MAIN, SCRIPT, SUBTREE, *_TAGS, *COMPOSITES, *MODIFIERS, *_SWITCH_TAGS})
"""Names in the XML that neither a task nor a leaf can have."""

RESERVED_PORTS = frozenset({"ID", "name"})
"""Attributes with a meaning of their own, besides those that begin with `_`."""

ANY_TYPE = "BT::AnyTypeAllowed"

_PORT_TYPES = {
    "bool": "bool",
    "int": "int",
    "float": "double",
    "text": "std::string",
    "pose": "Pose",
    "tool_pose": "ToolPose",
    "base_pose": "BasePose",
    "posture": "Posture",
    "region": "Region",
    "object": "DetectedObject",
}
"""The name of a port's type, by the type of a parameter in a task file."""

_POINTER = re.compile(r"\{\s*([A-Za-z_][A-Za-z0-9_]*)\s*\}")


def pointer(name: str) -> str:
    """The attribute that stands for an entry of the blackboard."""
    return f"{{{name}}}"


def pointed_at(text: str) -> str | None:
    """The name of the entry that an attribute stands for; None if it is a literal."""
    match = _POINTER.fullmatch(text)
    return match[1] if match else None


def literal(value: Plain) -> str:
    """A value as the text of an attribute."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return repr(value) if isinstance(value, float) else str(value)


def survives(value: Plain, expected: ValueType | None) -> bool:
    """Whether the literal of a value is read as the same value.

    `expected` is the type of the port; None if it takes any.
    """
    text = literal(value)
    if not text.isprintable() or (text.lstrip()[:1], text.rstrip()[-1:]) == ("{", "}"):
        return False
    if not isinstance(value, str):
        return True
    is_choice = expected is not None and value in expected.choices
    read = parse_scalar(text)
    # A port that takes text alone does not guess; the others read a number where they can.
    return is_choice or read == value or (expected is not None and type(read) not in expected.types)


def port_type(expected: ValueType) -> str:
    """The name of a port's type."""
    types = {one for one in expected.types if one is not type(None)}
    types = types or {type(choice) for choice in expected.choices}
    for word, known in PARAMETER_TYPES.items():
        if set(known.types) == types:
            return _PORT_TYPES[word]
    return ANY_TYPE


def parameter_port(name: str, parameter: TaskParameter, expected: ValueType) -> Element:
    """The port of a tree that takes a parameter of its task."""
    port = Element("input_port", name=name, type=port_type(expected))
    if parameter.default is not None:
        port.set("default", literal(parameter.default.value))
    port.text = parameter.description or None
    return port


def leaf_model(leaf: LeafType) -> Element:
    """The model of a leaf, with its ports."""
    model = Element("Condition" if leaf.is_condition else "Action", ID=leaf.key)
    for parameter in leaf.parameters.values():
        port = SubElement(model, "input_port", name=parameter.name)
        port.set("type", port_type(parameter.type))
        default = "" if parameter.default is None else parameter.default
        if isinstance(default, bool | int | float | str) and not parameter.required:
            port.set("default", literal(default))
        port.text = parameter.description or None
    for output in leaf.outputs.values():
        port = SubElement(model, "output_port", name=output.name, type=port_type(output.type))
        port.text = output.description or None
    return model


def pose_text(pose: NamedValue) -> str:
    """A pose or region as text, with the keys of a task file."""
    return "; ".join(f"{key}: {_numbers(values)}" for key, values in _fields(pose).items())


def _fields(pose: NamedValue) -> dict[str, Array]:
    if isinstance(pose, ToolPose):
        turn = np.rad2deg(pin.rpy.matrixToRpy(pose.mTe.rotation))
        return {"xyz": pose.mTe.translation, "rpy_deg": turn}
    if isinstance(pose, BasePose):
        return {"base": pose.mTb.translation[:2], "heading_deg": _yaw_deg(pose.mTb)}
    if isinstance(pose, Posture):
        return {"joints_deg": np.rad2deg(pose.q)}
    assert isinstance(pose, Region)
    yaw = _yaw_deg(pose.mTr)
    turned = {} if not yaw[0] else {"yaw_deg": yaw}
    return {"centre": pose.mTr.translation, "size": pose.size, **turned}


def _yaw_deg(pose: SE3) -> Array:
    return np.rad2deg([yaw_of(pose.rotation)])


def _numbers(values: Array) -> str:
    # Twelve digits give what a person wrote, in spite of the way through radians.
    return " ".join(f"{value + 0.0:.12g}" for value in np.round(values, 10))


def standard_attributes(counterpart: Counterpart, value: object) -> dict[str, str] | None:
    """The attributes of the counterpart of a modifier; None if it cannot take the value."""
    if not counterpart.port:
        return dict(counterpart.fixed)
    if isinstance(value, KeyRead) and counterpart.scale == 1:
        return {counterpart.port: pointer(value.name)}
    if isinstance(value, int | float):
        whole = round(value * counterpart.scale)
        if whole / counterpart.scale == value:
            return {counterpart.port: str(whole)}
    return None


def switch_attributes(variable: str, cases: Sequence[str]) -> dict[str, str]:
    """The attributes of a `Switch2` to `Switch6`; its last child is the default."""
    numbered = {f"case_{place}": case for place, case in enumerate(cases, 1)}
    return {"variable": variable} | numbered


def parallel_counts(policy: object, children: int) -> dict[str, str]:
    """The attributes of a `Parallel` for a policy of `parallel`."""
    if policy == "all":
        return {"success_count": "-1", "failure_count": "1"}
    if policy == "any":
        return {"success_count": "1", "failure_count": "-1"}
    return {"success_count": str(policy), "failure_count": str(children - int(str(policy)) + 1)}
