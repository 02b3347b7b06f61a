"""The section `params`: what a task may be told from outside, and what `$name` stands for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from config import suggest
from trees.language.diagnostics import Diagnostics, Location
from trees.language.source import Entry, Items, Reference, Scalar, Table, Value, plain
from trees.language.tables import WORD, fields, named_entries
from trees.language.value_types import (
    PARAMETER_TYPES,
    Named,
    ValueType,
    type_of,
    written,
)
from trees.language.values import Given, KeyRead, MismatchError, convert, describe


@dataclass(frozen=True, kw_only=True)
class TaskParameter:
    """A value of a task that may be chosen from outside."""

    place: Location
    type: ValueType | None
    """None if its definition is not sound; that is noted as a diagnostic."""
    default: Scalar | None = None
    """None if a value has to be given."""
    description: str = ""
    value: Given = None
    """What it is this time; a `KeyRead` is a key of the including file, None is none."""

    @property
    def is_late(self) -> bool:
        """Whether its value is known only while the task runs, or not given at all."""
        return isinstance(self.value, KeyRead) or self.is_open

    @property
    def is_open(self) -> bool:
        """Whether it is sound and has no value yet."""
        return self.value is None and self.type is not None


def read_parameters(entry: Entry | None, diagnostics: Diagnostics) -> dict[str, TaskParameter]:
    """The parameters that a file declares, still without values."""
    return {
        name: _read_parameter(name, place, value, diagnostics)
        for name, place, value in named_entries(entry, "params", diagnostics)
    }


def _read_parameter(
    name: str, place: Location, value: Value, diagnostics: Diagnostics
) -> TaskParameter:
    what = f"parameter `{name}`"
    unsound = TaskParameter(place=place, type=None)
    if isinstance(value, Scalar) and _is_usable(value):
        hint = f"write `{name}: {{default: {written(value.value)}}}`"
        diagnostics.error(value.place, f"{what} is a mapping, not {describe(value)}", hint)
        return unsound
    entries = fields(
        value, what, diagnostics, optional=("type", "default", "description", "min", "max")
    )
    if entries is None:
        return unsound
    default = entries["default"].value if "default" in entries else None
    if default is not None and not _is_usable(default):
        hint = "give a number, a text, `true` or `false`, or leave it out and give a `type`"
        diagnostics.error(default.place, f"{what} has no usable default", hint)
        return unsound
    assert default is None or isinstance(default, Scalar)
    if "type" in entries:
        expected = _read_type(entries["type"].value, what, diagnostics)
    elif default is not None:
        expected = type_of(default.value)
    else:
        hint = "add a `default`, or a `type` if a value has to be given"
        diagnostics.error(place, f"{what} has neither `type` nor `default`", hint)
        return unsound
    if expected is not None:
        expected = _read_bounds(expected, entries, what, diagnostics)
    if expected is None:
        return unsound
    description = entries.get("description")
    text = description.value.value if description and isinstance(description.value, Scalar) else ""
    return TaskParameter(
        place=place, type=expected, default=default, description=str(text or "").strip()
    )


def _is_usable(value: Value) -> bool:
    if not isinstance(value, Scalar) or value.value is None:
        return False
    if isinstance(value.value, float):
        return math.isfinite(value.value)
    return not str(value.value).startswith("$")


def _read_type(value: Value, what: str, diagnostics: Diagnostics) -> ValueType | None:
    """The type that a word or a list of choices stands for."""
    if isinstance(value, Items) and value.items:
        choices = [item.value for item in value.items if isinstance(item, Scalar)]
        if len(choices) == len(value.items) and None not in choices:
            return ValueType(kinds=(), choices=tuple(choices))
        diagnostics.error(value.place, f"{what} has choices that are not plain", "list words")
        return None
    word = value.value if isinstance(value, Scalar) else None
    if isinstance(word, str) and word in PARAMETER_TYPES:
        return PARAMETER_TYPES[word]
    hint = f"{suggest(str(word), PARAMETER_TYPES)} (or a list of choices)"
    diagnostics.error(value.place, f"{what} cannot be of the type {describe(value)}", hint)
    return None


def _read_bounds(
    expected: ValueType, entries: Mapping[str, Entry], what: str, diagnostics: Diagnostics
) -> ValueType | None:
    """The type within `min` and `max`, if the file gives them."""
    bounds: dict[str, float | None] = {"min": None, "max": None}
    number = ValueType(kinds=(float,))
    for key in bounds:
        if key not in entries:
            continue
        entry = entries[key]
        if not _is_number(expected):
            diagnostics.error(entry.place, f"{what} is no number: it has no `{key}`", "remove it")
            return None
        try:
            given = convert(entry.value, number, {})
        except MismatchError as mismatch:
            diagnostics.error(entry.value.place, f"`{key}`: {mismatch.what}", mismatch.hint)
            return None
        assert isinstance(given, float)
        bounds[key] = given
    least, most = bounds["min"], bounds["max"]
    if least is not None and most is not None and least > most:
        hint = "swap them"
        diagnostics.error(entries["min"].place, f"{what} has a `min` above its `max`", hint)
        return None
    return replace(expected, least=least, most=most)


def given_texts(
    parameters: Mapping[str, TaskParameter],
    texts: Mapping[str, str],
    entry: Entry | None,
    diagnostics: Diagnostics,
) -> dict[str, Scalar]:
    """The values that a person gives by `-p name=text`; unknown names are diagnostics.

    Args:
        parameters: those of the file.
        entry: the section that declares them, if there is one.
        texts: written as in YAML; a text parameter takes them as they are.
        diagnostics: where they are noted.
    """
    given = {}
    for name, text in texts.items():
        if name not in parameters:
            what = f"`-p {name}={text}`: the task has no parameter `{name}`"
            at = entry.place if entry else Location(line=1, column=1)
            diagnostics.error(at, what, suggest(name, parameters))
            continue
        expected = parameters[name].type
        as_text = expected is not None and str in expected.kinds
        value = text if as_text else plain(text.strip())
        given[name] = Scalar(place=parameters[name].place, value=value)
    return given


def with_values(
    parameters: Mapping[str, TaskParameter],
    given: Mapping[str, Scalar],
    named: Mapping[str, Named] | None,
    diagnostics: Diagnostics,
) -> dict[str, TaskParameter]:
    """The parameters with values: those given by a person, else the defaults.

    Args:
        parameters: as declared, or with the value that an including file gives.
        given: by a person.
        named: the poses, postures and regions that a name may stand for; None leaves the
            parameters alone that take such a name.
        diagnostics: where values that do not fit are noted.
    """
    return {
        name: _with_value(name, parameter, given.get(name), named, diagnostics)
        for name, parameter in parameters.items()
    }


def _with_value(
    name: str,
    parameter: TaskParameter,
    given: Scalar | None,
    named: Mapping[str, Named] | None,
    diagnostics: Diagnostics,
) -> TaskParameter:
    source = given or parameter.default
    if parameter.value is not None or parameter.type is None or source is None:
        return parameter
    if named is None and parameter.type.named_kinds:
        return parameter
    try:
        return replace(parameter, value=convert(source, parameter.type, named or {}))
    except MismatchError as mismatch:
        whose = f"`-p {name}={source.value}`" if given else f"the default of `{name}`"
        diagnostics.error(source.place, f"{whose}: {mismatch.what}", mismatch.hint)
        return replace(parameter, type=None)


def substitute(
    value: Value,
    parameters: Mapping[str, TaskParameter],
    used: set[str],
    diagnostics: Diagnostics,
    *,
    keys: bool,
) -> Value:
    """The value with what every `$name` stands for.

    Args:
        value: from the file.
        parameters: with their values.
        used: receives the names of the parameters met.
        diagnostics: where names that stand for nothing are noted.
        keys: whether a name that is no parameter is a key; else it is a diagnostic.
    """

    def replaced(value: Value) -> Value:
        if isinstance(value, Items):
            return replace(value, items=tuple(map(replaced, value.items)))
        if isinstance(value, Table):
            entries = value.entries.items()
            table = {key: replace(entry, value=replaced(entry.value)) for key, entry in entries}
            return replace(value, entries=table)
        text = value.value if isinstance(value, Scalar) else None
        if not isinstance(text, str) or not text.startswith("$"):
            return value
        name = text[1:]
        if name in parameters:
            used.add(name)
            parameter = parameters[name]
            if not keys and parameter.is_open and _is_number(parameter.type):
                # A task with such a parameter is looked at only: any number will do.
                return Scalar(place=value.place, value=1.0, parameter=name)
            return _stand_in(value.place, name, parameter)
        if keys and WORD.fullmatch(name):
            return Reference(place=value.place, name=name)
        diagnostics.error(value.place, *no_parameter(name, parameters))
        return Scalar(place=value.place, value=None, parameter=name)

    return replaced(value)


def _is_number(expected: ValueType | None) -> bool:
    return expected is not None and not {int, float}.isdisjoint(expected.kinds)


def _stand_in(place: Location, name: str, parameter: TaskParameter) -> Value:
    """What stands for a parameter."""
    if parameter.is_late:
        return Reference(place=place, name=name)
    value = parameter.value
    if isinstance(value, Named):
        return Reference(place=place, name=name, value=value)
    assert not isinstance(value, KeyRead)
    return Scalar(place=place, value=value, parameter=name)


def no_parameter(name: str, parameters: Mapping[str, TaskParameter]) -> tuple[str, str]:
    """What is wrong with a `$` that stands for nothing, and how to fix it."""
    if not WORD.fullmatch(name):
        what = f"`${name}` begins with `$` and is neither a parameter nor a key"
        return what, "write `$` and its name"
    hint = suggest(name, parameters) if parameters else "define it under `params:`"
    return f"the task has no parameter `{name}`", hint
