"""Values as the text of XML attributes, and back: literals, and `{name}` for what has a name."""

from __future__ import annotations

import re

from trees.btcpp.words import ANY_TYPE, PORT_TYPES
from trees.language.source import plain
from trees.language.value_types import PARAMETER_TYPES, Plain, ValueType

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


def read_literal(text: str, expected: ValueType | None) -> Plain:
    """What an attribute says, as the value of a type; None as a type is any."""
    value = plain(text)
    if expected is None:
        return value
    is_choice = any(value == one and type(value) is type(one) for one in expected.choices)
    number = float in expected.kinds and type(value) is int
    return value if is_choice or number or type(value) in expected.kinds else text


def survives(value: Plain, expected: ValueType | None) -> bool:
    """Whether a value written as a literal is read as the same value again."""
    text = literal(value)
    if not text.isprintable() or (text.lstrip()[:1], text.rstrip()[-1:]) == ("{", "}"):
        return False
    again = read_literal(text, expected)
    return again == value and (type(again) is type(value) or isinstance(value, float))


def port_type(expected: ValueType) -> str:
    """What the type of a port is called."""
    kinds = tuple(kind for kind in expected.kinds if kind is not type(None))
    if not kinds and expected.choices:
        kinds = tuple({type(choice): None for choice in expected.choices})
    for word, known in PARAMETER_TYPES.items():
        if set(known.kinds) == set(kinds):
            return PORT_TYPES[word]
    return ANY_TYPE
