"""The section `params`, its overrides from outside, and what `$name` stands for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from trees.language.mistakes import Mistakes, Place, suggestion
from trees.language.source import Entry, Items, Plain, Scalar, Table, Value, plain
from trees.language.tables import WORD, fields, named_entries
from trees.language.values import MismatchError, convert, type_of


@dataclass(frozen=True, kw_only=True)
class TaskParameter:
    """A value of a task that may be chosen from outside."""

    place: Place
    value: Plain
    """None if its definition is not sound; that is noted as a mistake."""
    description: str = ""


def read_parameters(
    entry: Entry | None, overrides: Mapping[str, str], mistakes: Mistakes
) -> dict[str, TaskParameter]:
    """The parameters of a task, with the overrides in place of the defaults.

    Args:
        entry: the section, if there is one.
        overrides: texts by name, written as in YAML; a text parameter takes them as they are.
        mistakes: where they are noted.
    """
    parameters = {}
    for name, place, value in named_entries(entry, "params", mistakes):
        parameters[name] = _read_parameter(name, place, value, mistakes)
    for name, text in overrides.items():
        if name in parameters:
            parameters[name] = _overridden(name, parameters[name], text, mistakes)
        else:
            what = f"`-p {name}={text}`: the task has no parameter `{name}`"
            at = entry.place if entry else Place(line=1, column=1)
            mistakes.error(at, what, suggestion(name, parameters))
    return parameters


def _read_parameter(name: str, place: Place, value: Value, mistakes: Mistakes) -> TaskParameter:
    what = f"parameter `{name}`"
    entries = fields(value, what, mistakes, required=("default",), optional=("description",))
    if entries is None:
        return TaskParameter(place=place, value=None)
    default = entries["default"].value
    if not isinstance(default, Scalar) or default.value is None or not _is_finite(default.value):
        mend = "its type is that of its default: give a number, a text, `true` or `false`"
        mistakes.error(default.place, f"{what} has no usable default", mend)
        return TaskParameter(place=place, value=None)
    description = entries.get("description")
    text = description.value.value if description and isinstance(description.value, Scalar) else ""
    return TaskParameter(place=place, value=default.value, description=str(text or ""))


def _is_finite(value: Plain) -> bool:
    return not isinstance(value, float) or math.isfinite(value)


def _overridden(
    name: str, parameter: TaskParameter, text: str, mistakes: Mistakes
) -> TaskParameter:
    if parameter.value is None:
        return parameter
    if isinstance(parameter.value, str):
        return replace(parameter, value=text)
    given = Scalar(place=parameter.place, value=plain(text.strip()))
    try:
        value = convert(given, type_of(parameter.value), {})
    except MismatchError as mismatch:
        what = f"`-p {name}={text}`: {mismatch.what}"
        mistakes.error(parameter.place, what, mismatch.mend)
        return parameter
    assert value is None or isinstance(value, bool | int | float | str)
    return replace(parameter, value=value)


def substitute(
    value: Value, parameters: Mapping[str, TaskParameter], used: set[str], mistakes: Mistakes
) -> Value:
    """The value with every text `$name` replaced by the parameter's value.

    Args:
        value: from the file.
        parameters: what names stand for.
        used: receives the names met.
        mistakes: where unknown names are noted.
    """
    if isinstance(value, Items):
        items = (substitute(item, parameters, used, mistakes) for item in value.items)
        return replace(value, items=tuple(items))
    if isinstance(value, Table):
        entries = {
            key: replace(entry, value=substitute(entry.value, parameters, used, mistakes))
            for key, entry in value.entries.items()
        }
        return replace(value, entries=entries)
    if not isinstance(value.value, str) or not value.value.startswith("$"):
        return value
    name = value.value[1:]
    if name in parameters:
        used.add(name)
        return replace(value, value=parameters[name].value, parameter=name)
    if WORD.fullmatch(name):
        mend = suggestion(name, parameters) if parameters else "define it under `params:`"
        mistakes.error(value.place, f"the task has no parameter `{name}`", mend)
    else:
        what = f"`{value.value}` begins with `$` and is not a parameter"
        mistakes.error(value.place, what, "write `$` and the name of a parameter")
    return replace(value, value=None, parameter=name)
