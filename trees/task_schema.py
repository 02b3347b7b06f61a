"""The JSON Schema of task files, with which an editor completes, explains and checks them.

It is made from the words of the language and the constructors of the leaves, in draft 07, which
every YAML language server knows. A node is one object with all keys as properties, so that an
editor offers each key once. `frankie-task check` checks the rest.
"""

import json
import types
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from config.reader import StrictModel
from trees.language import (
    ADD,
    ASKING,
    CHILDREN,
    COMPOSITES,
    FILE_KEYS,
    MODIFIERS,
    NAME,
    SUBTREE,
    WORD,
    CompositeWord,
    Form,
    LeafType,
    ModifierWord,
    Output,
    Parameter,
    ParameterSection,
    PoseSection,
    RegionSection,
    ValueType,
)

Schema: TypeAlias = dict[str, Any]

SCHEMA_FILE = Path(__file__).parent / "frankie-task.schema.json"
"""The schema beside the shipped tasks, which name it at their top; `install.sh` writes it."""

_REFERENCE = rf"\${WORD.pattern}"  # a parameter or key in place of a value

_NODE: Schema = {"$ref": "#/definitions/node"}
_POSE: Schema = {"$ref": "#/definitions/pose"}
_PATH: Schema = {"type": "array", "items": _POSE, "minItems": 1}
_CONDITION: Schema = {"$ref": "#/definitions/condition"}
_TEXT: Schema = {"type": "string"}
_WORD: Schema = {"type": "string", "pattern": f"^{WORD.pattern}$"}
_NAMED_VALUE: Schema = {
    "pattern": f"^{_REFERENCE}$",
    "patternErrorMessage": "The value has another type; `$name` stands for a parameter or key.",
}
"""The part of a schema that allows a reference in place of a value."""

_JSON_TYPES: Mapping[type, str] = {
    bool: "boolean",
    int: "integer",
    float: "number",
    types.NoneType: "null",
}


def schema_text(leaves: Mapping[str, LeafType]) -> str:
    """The schema as the text of a file."""
    return json.dumps(task_schema(leaves), indent=2, ensure_ascii=False) + "\n"


def task_schema(leaves: Mapping[str, LeafType]) -> Schema:
    """The schema of a task file."""
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "frankie-task",
        "description": "A task for a mobile manipulator: a behaviour tree and what it refers to.",
        **_table(
            {key: {**_SECTIONS[key], "description": about} for key, about in FILE_KEYS.items()},
            required=["task", "tree"],
        ),
        "definitions": {
            "node": _node(leaves),
            "condition": _condition(leaves),
            "pose": _section(PoseSection),
        },
    }


def _node(leaves: Mapping[str, LeafType]) -> Schema:
    """One object that has every node and every modifier, or the bare key of a leaf."""
    others = {
        SUBTREE: _SUBTREE,
        NAME: {**_TEXT, "description": "The node's name in pictures and messages."},
        **{key: _modifier(word) for key, word in MODIFIERS.items()},
    }
    return _one_of(leaves, COMPOSITES, others)


def _condition(leaves: Mapping[str, LeafType]) -> Schema:
    """What may stand after `while` or `unless`."""
    conditions = {key: leaf for key, leaf in leaves.items() if leaf.is_condition}
    asking = {key: word for key, word in COMPOSITES.items() if word.is_condition}
    return _one_of(conditions, asking | dict(ASKING), {}) | {"maxProperties": 1}


def _one_of(
    leaves: Mapping[str, LeafType],
    composites: Mapping[str, type[CompositeWord]],
    others: Mapping[str, Schema],
) -> Schema:
    """An object with these keys, or the bare key of a leaf that needs no parameters."""
    bare = (key for key, leaf in leaves.items() if not leaf.names_keys and not _required(leaf))
    properties = {
        **{key: _leaf(leaf) for key, leaf in leaves.items()},
        **{key: _composite(word) for key, word in composites.items()},
        **others,
    }
    return {
        "pattern": f"^({'|'.join(bare)})$",
        "patternErrorMessage": "Expected one that needs no parameters; the others are written "
        "`name: {...}`.",
        **_table(properties),
        "type": ["object", "string"],
        "minProperties": 1,
    }


def _leaf(leaf: LeafType) -> Schema:
    required = _required(leaf)
    properties = {one.name: _described(one) for one in leaf.described}
    any_value: Schema | bool = _value(ValueType(types=(float,))) if leaf is ADD else True
    values = (
        {"type": "object", "minProperties": 1, "additionalProperties": any_value}
        if leaf.names_keys
        else _table(properties, required=required)
    )
    nothing = [] if required or leaf.names_keys else ["null"]
    return {**values, "type": ["object", *nothing], "description": leaf.description}


def _required(leaf: LeafType) -> list[str]:
    return [one.name for one in leaf.described if one.required]


def _described(one: Parameter) -> Schema:
    if isinstance(one, Output):
        return {**_WORD, "description": f"{_about(one)} Give the key to write it to."}
    schema = {**_value(one.type), "description": _about(one)}
    plain = isinstance(one.default, bool | int | float | str)
    return {**schema, "default": one.default} if plain else schema


def _about(described: Parameter) -> str:
    text = described.description
    text = f"{text[:1].upper()}{text[1:]}." if text else f"{described.name}."
    return text if described.unit in ("", "%") or "[" in text else f"{text} [{described.unit}]"


def _composite(word: type[CompositeWord]) -> Schema:
    """A list of nodes, or, if the word allows, one node or a mapping of options and children."""
    least = {"minItems": word.least, **({} if word.most is None else {"maxItems": word.most})}
    node = _CONDITION if word.asks else _NODE
    nodes: Schema = {"type": "array", "items": node, **least}
    about = {"description": f"{word.description} It takes {word.takes}."}
    if word.form is not Form.LIST:
        return _FORMS[word.form] | about
    if word.lone:
        return {**about, "if": {"type": "array"}, "then": nodes, "else": node}
    if not word.options:
        return {**nodes, **about}
    options = {
        key: {**_value(option.type), "description": option.description, "default": option.default}
        for key, option in word.options.items()
    }
    table = _table({**options, CHILDREN: nodes}, required=[CHILDREN])
    return {**about, **nodes, **table, "type": ["array", "object"]}


def _modifier(word: type[ModifierWord]) -> Schema:
    about = {"description": word.description}
    if word.type is None:
        return {"allOf": [_CONDITION], **about}
    return {**_value(word.type), **about}


def _value(expected: ValueType) -> Schema:
    """A value of a type, or a reference to one."""
    limits = {
        "exclusiveMinimum": expected.above,
        "minimum": expected.least,
        "maximum": expected.most,
    }
    types = [_JSON_TYPES[one] for one in expected.types if one in _JSON_TYPES]
    is_text = str in expected.types or bool(expected.named_types)
    value = {
        "type": [*types, "string"],
        **({} if is_text else _NAMED_VALUE),
        **{key: bound for key, bound in limits.items() if bound is not None},
    }
    return {"anyOf": [{"enum": list(expected.choices)}, value]} if expected.choices else value


def _table(properties: Mapping[str, Schema], *, required: Sequence[str] = ()) -> Schema:
    """A mapping with no other keys than these."""
    schema = {"type": "object", "properties": dict(properties), "additionalProperties": False}
    return {**schema, "required": list(required)} if required else schema


def _section(model: type[StrictModel]) -> Schema:
    """The schema of a model, without what only pydantic needs."""
    schema = model.model_json_schema()
    properties = {
        key: {
            name: value
            for name, value in about.items()
            if name != "title" and (name, value) != ("default", None)
        }
        for key, about in schema["properties"].items()
    }
    return _table(properties, required=schema.get("required", ()))


def _named(entry: Schema) -> Schema:
    """A mapping of names; the section may be empty."""
    return {
        "type": ["object", "null"],
        "propertyNames": {"pattern": f"^{WORD.pattern}$"},
        "additionalProperties": entry,
    }


_SECTIONS: Mapping[str, Schema] = {
    "task": _WORD,
    "description": _TEXT,
    "scene": _TEXT,
    "params": _named(_section(ParameterSection)),
    "outputs": _named({"type": ["string", "null"]}),
    "poses": _named({"if": {"type": "array"}, "then": _PATH, "else": _POSE}),
    "regions": _named(_section(RegionSection)),
    "tree": {"allOf": [_NODE]},
}
_SCALAR: Schema = {"type": ["boolean", "number", "string"]}
_FORMS: Mapping[Form, Schema] = {
    Form.CASES: _table(
        {
            "value": _SCALAR,
            "cases": {"type": "object", "minProperties": 1, "additionalProperties": _NODE},
            "else": _NODE,
        },
        required=["value", "cases"],
    ),
    Form.EACH: _table(
        {
            "item": _WORD,
            "in": {
                "type": ["array", "string"],
                "items": _SCALAR,
                "minItems": 1,
                "maxItems": 100,
            },
            "do": _NODE,
        },
        required=["item", "in", "do"],
    ),
}
_VALUES = {"type": "object", "additionalProperties": True}
_SUBTREE = {
    **_table(
        {
            "file": {**_TEXT, "description": "The other task file, seen from this one."},
            "with": {**_VALUES, "description": "Values for its parameters."},
            "out": {**_VALUES, "description": "For each of its outputs, the key to write it to."},
        },
        required=["file"],
    ),
    "description": "Runs the tree of another file, which has names and keys of its own.",
}
