"""Reads strict YAML into pydantic models; reports all errors at once with location and hint."""

import json
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from config.diagnostics import Diagnostics, Location, UserError, counted, suggest
from config.strict_yaml import (
    YamlList,
    YamlMap,
    YamlScalar,
    YamlValue,
    content,
    describe,
    read_yaml,
)
from config.yaml_rules import MISSING_KEY, UNKNOWN_KEY, VALUE

Model = TypeVar("Model", bound=BaseModel)
_Keys: TypeAlias = tuple[int | str, ...]

_EXPECTED = {
    "string_type": "text",
    "bool_type": "true or false",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
    "greater_than": "a number greater than {gt:g}",
    "greater_than_equal": "a number of at least {ge:g}",
    "less_than": "a number less than {lt:g}",
    "less_than_equal": "a number of at most {le:g}",
    "literal_error": "{expected}",
}
"""Expectations in words of YAML, by pydantic's type of error."""

_RULES = {"extra_forbidden": UNKNOWN_KEY, "missing": MISSING_KEY}


class ConfigError(UserError):
    """A configuration file that cannot be used; the text says what, where and how to fix it."""


class StrictModel(BaseModel):
    """A frozen model without unknown keys and with finite numbers only."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def read_config(path: Path, model: type[Model], context: Any = None) -> Model:
    """The content of a YAML file as a model; `context` is that of its validators.

    Raises:
        ConfigError: with every error in the file, a line each.
    """
    diagnostics = Diagnostics(path)
    read = read_yaml(diagnostics)
    result = None if read is None else validate(read[1], model, diagnostics, context=context)
    if result is None or diagnostics.fatal:
        raise ConfigError("\n".join(map(str, diagnostics.in_order())))
    return result


def validate(
    value: YamlValue,
    model: type[Model],
    diagnostics: Diagnostics,
    *,
    name: str = "",
    location: Location | None = None,
    context: Any = None,
) -> Model | None:
    """A located value as a model, without conversions; None after an error in `diagnostics`.

    Args:
        value: from the file.
        model: its type.
        diagnostics: receives every error.
        name: of the value in messages; empty for the whole file.
        location: of its name, if it has one.
        context: of the validators of the model.
    """
    try:
        # The strict mode for JSON accepts a list for a tuple.
        text = json.dumps(content(value))
        return model.model_validate_json(text, strict=True, context=context)
    except ValidationError as invalid:
        seen = set()
        errors = [
            (error, _Position(value, location or value.location, error))
            for error in invalid.errors(include_url=False)
        ]
        for error, at in errors:
            # A union has one error for each member; the best fitting one is the deepest.
            is_deepest = not any(_is_below(other.keys, at.keys) for _, other in errors)
            if is_deepest and at.keys not in seen:
                seen.add(at.keys)
                known = _known_keys(model, error["loc"][:-1])
                rule = _RULES.get(error["type"], VALUE)
                diagnostics.error(rule, *at.explain(error, name, known))
    return None


def _is_below(keys: _Keys, above: _Keys) -> bool:
    return len(keys) > len(above) and keys[: len(above)] == above


class _Position:
    """The deepest value at the location of a pydantic error, without tags of union members."""

    def __init__(self, root: YamlValue, location: Location, error: Any) -> None:
        path: _Keys = error["loc"]
        self.value = root
        self.key_location = location
        self.parent = ""
        self.keys: _Keys = ()
        for place, key in enumerate(path, 1):
            if isinstance(self.value, YamlMap) and isinstance(key, str):
                is_told = place == len(path) and error["type"] in ("missing", "extra_forbidden")
                if key not in self.value.entries and not is_told:
                    continue
                self.keys += (key,)
                if key not in self.value.entries:
                    break
                entry = self.value.entries[key]
                self.value, self.key_location, self.parent = entry.value, entry.location, key
            elif isinstance(self.value, YamlList) and isinstance(key, int):
                self.keys += (key,)
                if key >= len(self.value.items):
                    break
                self.value = self.value.items[key]
                self.key_location = self.value.location

    def explain(self, error: Any, name: str, known: list[str]) -> tuple[Location, str, str]:
        """Location, message and hint for an error here."""
        path = ".".join(str(key) for key in (name, *self.keys) if key != "") or "the file"
        type_, context = error["type"], error.get("ctx", {})
        got = describe(self.value)
        if type_ == "extra_forbidden":
            return self.key_location, f"{path}: unknown key", suggest(str(self.keys[-1]), known)
        if type_ == "missing":
            holder = f"below `{self.parent or name}`" if self.parent or name else "at the top level"
            return self.key_location, f"{path}: is missing", f"add it {holder}"
        if type_ in ("too_short", "too_long"):
            bound = counted(context.get("min_length", context.get("max_length")), "value")
            message = f"{path}: expected {bound}, got {context['actual_length']}"
            most, count = context.get("max_length"), context["actual_length"]
            is_comma = most is not None and count == 2 * most
            hint = "a decimal has a point: 0.5, not 0,5" if is_comma else f"write {bound}"
            return self.value.location, message, hint
        if type_ == "value_error":
            text = str(context["error"])
            message, _, hint = text.partition("; " if "; " in text else ": ")
            return self._location, f"{path}: {message}", hint or "correct it"
        if type_ in _EXPECTED:
            expected = _EXPECTED[type_].format(**context).replace("'", "`")
            return self._location, f"{path}: expected {expected}, got {got}", f"write {expected}"
        message = error["msg"][:1].lower() + error["msg"][1:]
        return self._location, f"{path}: {message}, got {got}", "correct it"

    @property
    def _location(self) -> Location:
        """Of the value, or of its name for null and mappings."""
        is_null = isinstance(self.value, YamlScalar) and self.value.value is None
        is_key_better = is_null or isinstance(self.value, YamlMap)
        return self.key_location if is_key_better else self.value.location


def _known_keys(model: type[BaseModel], location: _Keys) -> list[str]:
    for key in location:
        field = model.model_fields.get(str(key))
        for inner in (field.annotation, *get_args(field.annotation)) if field else ():
            if isinstance(inner, type) and issubclass(inner, BaseModel):
                model = inner
    return list(model.model_fields)
