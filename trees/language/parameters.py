"""The section `params`: the parameters of a task."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

from pydantic import (
    Field,
    PlainValidator,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from config import (
    Diagnostics,
    Location,
    Plain,
    StrictModel,
    YamlEntry,
    YamlMap,
    YamlScalar,
    YamlValue,
    parse_scalar,
    suggest,
    validate,
    written,
)
from trees.language.mappings import ABSENT, named_entries
from trees.language.named_poses import NamedValues
from trees.language.value_types import PARAMETER_TYPES, ValueType, type_of
from trees.language.values import Argument, KeyRead, MismatchError, convert

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
    if not isinstance(value, bool | int | float | str) or _is_unusable(value):
        hint = "give a number, a text, `true` or `false`, or leave it out and give a `type`"
        raise ValueError(f"is no usable default; {hint}")
    return value


def _is_unusable(value: Plain) -> bool:
    return str(value).startswith("$") or (isinstance(value, float) and not math.isfinite(value))


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

    def value_type(self) -> ValueType:
        """Its type, with its bounds."""
        expected = self.type or type_of(self.default)
        return replace(expected, least=self.min, most=self.max)


@dataclass(frozen=True, kw_only=True)
class TaskParameter:
    """A parameter of a task."""

    location: Location
    type: ValueType | None
    """None if there is an error in its definition."""
    default: YamlScalar | None = None
    """None if a value has to be given."""
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


def read_parameters(entry: YamlEntry | None, diagnostics: Diagnostics) -> dict[str, TaskParameter]:
    """The parameters that a file declares, still without values."""
    return {
        name: _read_parameter(name, location, value, diagnostics)
        for name, location, value in named_entries(entry, "params", diagnostics)
    }


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
    return TaskParameter(
        location=location,
        type=section.value_type(),
        default=default,
        description=section.description.strip(),
    )


def override_values(
    parameters: Mapping[str, TaskParameter],
    overrides: Mapping[str, str],
    entry: YamlEntry | None,
    diagnostics: Diagnostics,
) -> dict[str, YamlScalar]:
    """The values of `-p name=text`; unknown names are errors.

    Args:
        parameters: of the file.
        overrides: texts as in YAML; a text parameter takes them unchanged.
        entry: the section `params`, if there is one.
        diagnostics: receives the errors.
    """
    values = {}
    for name, text in overrides.items():
        if name not in parameters:
            message = f"`-p {name}={text}`: the task has no parameter `{name}`"
            at = entry.location if entry else Location(line=1, column=1)
            diagnostics.error(at, message, suggest(name, parameters))
            continue
        expected = parameters[name].type
        as_text = expected is not None and str in expected.types
        value = text if as_text else parse_scalar(text.strip())
        values[name] = YamlScalar(location=parameters[name].location, value=value)
    return values


def with_values(
    parameters: Mapping[str, TaskParameter],
    overrides: Mapping[str, YamlScalar],
    named: NamedValues,
    diagnostics: Diagnostics,
) -> dict[str, TaskParameter]:
    """The parameters with values: of a person, else of an including file, else the default.

    Args:
        parameters: as declared, or with the value of an including file.
        overrides: values of a person.
        named: poses, postures and regions by name.
        diagnostics: receives an error for each invalid value.
    """
    return {
        name: _with_value(name, parameter, overrides.get(name), named, diagnostics)
        for name, parameter in parameters.items()
    }


def _with_value(
    name: str,
    parameter: TaskParameter,
    override: YamlScalar | None,
    named: NamedValues,
    diagnostics: Diagnostics,
) -> TaskParameter:
    source = override or parameter.default
    if parameter.value is not None or parameter.type is None or source is None:
        return parameter
    try:
        return replace(parameter, value=convert(source, parameter.type, named.values))
    except MismatchError as mismatch:
        if named.is_faulty(source.value):
            return replace(parameter, type=None)
        whose = f"`-p {name}={source.value}`" if override else f"the default of `{name}`"
        diagnostics.error(source.location, f"{whose}: {mismatch.message}", mismatch.hint)
        return replace(parameter, type=None)
