"""Declarations of the project's own leaves in a file, so that `check` need not import them.

`make declarations` writes the file from the classes, which take long to import.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

from trees.language.leaf_type import OWN_LEAVES, LeafType, Output, Parameter
from trees.language.value_types import TYPES_BY_NAME, ValueType

DECLARATIONS = Path(__file__).parent / "leaves.json"


@dataclass(frozen=True)
class Deferred:
    """A class or function that is imported when it is called."""

    where: str
    """As `package.module:name`."""

    def __call__(self, *args: Any, **named: Any) -> Any:
        """Call it."""
        return resolve_name(self.where)(*args, **named)


def declared_leaves() -> dict[str, LeafType]:
    """The project's own leaves, by their keys, `set` and `add` among them."""
    written = json.loads(DECLARATIONS.read_text(encoding="utf-8"))
    return dict(OWN_LEAVES) | {one["key"]: _read_leaf(one) for one in written}


def declarations_text(leaves: Mapping[str, LeafType]) -> str:
    """The content of the file."""
    own = [leaf for key, leaf in leaves.items() if key not in OWN_LEAVES]
    return json.dumps(own, default=_written, indent=1, ensure_ascii=False) + "\n"


def _written(value: Any) -> object:
    """What JSON has no word for: types by name, classes of leaves and functions by place."""
    if isinstance(value, LeafType):
        return _fields(value) | {"behaviour": _place(value.behaviour)}
    if isinstance(value, type):
        return value.__name__
    return _fields(value) if is_dataclass(value) else _place(value)


def _fields(value: Any) -> dict[str, Any]:
    """The fields of a dataclass that are not what they are by default."""
    given = ((field, getattr(value, field.name)) for field in fields(value))
    return {field.name: one for field, one in given if one != field.default and one != {}}


def _place(value: Any) -> str:
    return f"{value.__module__}:{value.__qualname__}"


def _read_leaf(written: dict[str, Any]) -> LeafType:
    tuples = {name: tuple(value) for name, value in written.items() if isinstance(value, list)}
    read = {
        "behaviour": Deferred(written["behaviour"]),
        "validate": Deferred(written["validate"]) if "validate" in written else None,
        "parameters": _read_each(Parameter, written.get("parameters", {})),
        "outputs": _read_each(Output, written.get("outputs", {})),
    }
    return LeafType(**(written | tuples | read))


def _read_each(kind: type[Any], written: dict[str, dict[str, Any]]) -> dict[str, Any]:
    each = ((name, one | {"type": _read_type(one["type"])}) for name, one in written.items())
    return {name: kind(**one) for name, one in each}


def _read_type(written: dict[str, Any]) -> ValueType:
    types = tuple(TYPES_BY_NAME[name] for name in written["types"])
    return ValueType(**(written | {"types": types, "choices": tuple(written.get("choices", ()))}))
