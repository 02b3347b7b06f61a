"""Sections of a task file, before its parameters have values; and the section `params`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

from pydantic import (
    AfterValidator,
    Field,
    PlainValidator,
    StringConstraints,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from config import (
    Diagnostics,
    Location,
    Plain,
    YamlEntry,
    YamlMap,
    YamlScalar,
    YamlValue,
    describe,
    read_yaml,
    suggest,
    written,
)
from config.reader import StrictModel, validate
from trees.language import rules
from trees.language.mappings import ABSENT, NAMING_HINT, WORD, fields, named_entries
from trees.language.values import Argument, KeyRead
from trees.words import PARAMETER_TYPES, ValueType, type_of

FILE_KEYS: Mapping[str, str] = {
    "task": "The name of the task.",
    "description": "What it does, for people.",
    "scene": "The simulated scene that it is written for.",
    "params": "What may be chosen from outside, each with a type or a default.",
    "outputs": "Keys that an including file may read, each with its meaning.",
    "poses": "Poses of hand, base and arm by name, in metres and degrees; a list is a path.",
    "regions": "Boxes in the world by name, in metres and degrees.",
    "tree": "The root of the tree: a single node.",
}
"""What may stand in a task file, with a line about each."""


def _word(text: str) -> str:
    if not WORD.fullmatch(text):
        raise ValueError(f"`{text}` is not a name; {NAMING_HINT}")
    return text


_Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class _Header(StrictModel):
    """What a file says about itself."""

    task: Annotated[_Text, AfterValidator(_word)]
    description: _Text = ""
    scene: _Text = ""


_SCALAR_SCHEMA = {"type": ["boolean", "number", "string"]}


def _read_type(value: object) -> ValueType:
    """The type that a word or a list of choices stands for."""
    if isinstance(value, list):
        if not value or not all(isinstance(one, bool | int | float | str) for one in value):
            raise ValueError("the choices are not plain values; list words or numbers")
        return ValueType(types=(), choices=tuple(value))
    if isinstance(value, str) and value in PARAMETER_TYPES:
        return PARAMETER_TYPES[value]
    hint = f"{suggest(str(value), PARAMETER_TYPES)} (or a list of choices)"
    raise ValueError(f"there is no type `{value}`; {hint}")


def _read_default(value: object) -> Plain:
    is_endless = isinstance(value, float) and not math.isfinite(value)
    if not isinstance(value, bool | int | float | str) or str(value).startswith("$") or is_endless:
        hint = "give a number, a text, `true` or `false`, or leave it out and give a `type`"
        raise ValueError(f"is no usable default; {hint}")
    return value


class ParameterSection(StrictModel):
    """The definition of a parameter in a task file."""

    type: Annotated[
        ValueType,
        PlainValidator(_read_type),
        WithJsonSchema(
            {"anyOf": [{"enum": list(PARAMETER_TYPES)}, {"type": "array", "items": _SCALAR_SCHEMA}]}
        ),
    ] = Field(
        default=ABSENT,
        description="Its type, or a list of choices; without it, that of the default.",
    )
    default: Annotated[Plain, PlainValidator(_read_default), WithJsonSchema(_SCALAR_SCHEMA)] = (
        Field(default=ABSENT, description="Its value unless chosen; without it, required.")
    )
    description: str = Field(default="", description="What it is for.")
    min: float = Field(default=ABSENT, description="Least number allowed.")
    max: float = Field(default=ABSENT, description="Largest number allowed.")

    @model_validator(mode="before")
    @classmethod
    def _mapping(cls, value: object) -> object:
        if isinstance(value, bool | int | float | str):
            raise ValueError(f"is not a mapping; write `{{default: {written(value)}}}`")
        return value

    @field_validator("min", "max")
    @classmethod
    def _bounds(cls, bound: float, info: ValidationInfo) -> float:
        expected = info.data.get("type") or type_of(info.data.get("default"))
        if {"type", "default"} <= set(info.data) and not expected.is_number:
            raise ValueError("only numbers have bounds; remove it")
        least = info.data.get("min") if info.field_name == "max" else None
        if least is not None and least > bound:
            raise ValueError("is less than `min`; swap them")
        return bound

    @model_validator(mode="after")
    def _typed(self) -> ParameterSection:
        if not {"type", "default"} & self.model_fields_set:
            hint = "add a `default`, or a `type` if a value has to be given"
            raise ValueError(f"has neither `type` nor `default`; {hint}")
        return self


@dataclass(frozen=True, kw_only=True)
class TaskParameter:
    """A parameter of a task."""

    location: Location
    type: ValueType | None  # None if there is an error in its definition
    default: YamlScalar | None = None  # None if a value has to be given
    description: str = ""
    value: Argument = None
    """Its value in this run; a `KeyRead` is a key of the including file, None is no value yet."""

    @property
    def is_late(self) -> bool:
        """Whether its value is known only during the run, or missing."""
        return isinstance(self.value, KeyRead) or self.is_open

    @property
    def is_open(self) -> bool:
        """Whether it is valid and has no value yet."""
        return self.value is None and self.type is not None


def _read_parameter(
    name: str, location: Location, value: YamlValue, diagnostics: Diagnostics
) -> TaskParameter:
    section = validate(
        value, ParameterSection, diagnostics, name=f"params.{name}", location=location
    )
    if section is None:
        return TaskParameter(location=location, type=None)
    assert isinstance(value, YamlMap)
    default = value.entries["default"].value if "default" in value.entries else None
    assert default is None or isinstance(default, YamlScalar)
    expected = section.type or type_of(section.default)
    return TaskParameter(
        location=location,
        type=replace(expected, least=section.min, most=section.max),
        default=default,
        description=section.description.strip(),
    )


@dataclass(frozen=True, kw_only=True)
class TaskOutput:
    """A key whose value an including file may read."""

    location: Location
    description: str
    type: ValueType | None = None  # what the tree writes to it; None before the tree is read


@dataclass(frozen=True, kw_only=True)
class Document:
    """The sections of a file."""

    text: str
    name: str
    description: str
    scene: str
    parameters: Mapping[str, TaskParameter]
    outputs: Mapping[str, TaskOutput]
    entries: Mapping[str, YamlEntry]  # all sections as they were read


def read_document(diagnostics: Diagnostics) -> Document | None:
    """The sections of the diagnosed file; None if it is unreadable."""
    read = read_yaml(diagnostics)
    if read is None:
        return None
    text, document = read
    required = ("task", "tree")
    optional = [key for key in FILE_KEYS if key not in required]
    entries = fields(document, "the file", diagnostics, required=required, optional=optional)
    if entries is None or not isinstance(document, YamlMap):
        return None
    about = {key: entries[key] for key in _Header.model_fields if key in entries}
    header = validate(replace(document, entries=about), _Header, diagnostics)
    parameters = {
        name: _read_parameter(name, location, value, diagnostics)
        for name, location, value in named_entries(entries.get("params"), "params", diagnostics)
    }
    return Document(
        text=text,
        name=header.task if header else "",
        description=header.description if header else "",
        scene=header.scene if header else "",
        parameters=parameters,
        outputs=_read_outputs(entries.get("outputs"), parameters, diagnostics),
        entries=entries,
    )


def _read_outputs(
    entry: YamlEntry | None, parameters: Mapping[str, TaskParameter], diagnostics: Diagnostics
) -> dict[str, TaskOutput]:
    outputs = {}
    for name, location, value in named_entries(entry, "outputs", diagnostics):
        text = value.value if isinstance(value, YamlScalar) else value
        if name in parameters:
            message = f"`{name}` is a parameter, and cannot be written to"
            diagnostics.error(rules.NAMING, location, message, "choose another name for the key")
        elif text is None or isinstance(text, str):
            outputs[name] = TaskOutput(location=location, description=text or "")
        else:
            message = f"the output `{name}` is described by a text, not {describe(value)}"
            diagnostics.error(rules.VALUE, value.location, message, "write what it means")
    return outputs
