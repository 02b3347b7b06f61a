"""Configuration files: YAML in, a checked pydantic model out, every complaint with its place."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar, get_args

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError

from config.errors import UserError, suggest

Model = TypeVar("Model", bound=BaseModel)


class ConfigError(UserError):
    """A configuration file that cannot be used; the text says what, where and how to fix it."""


class StrictModel(BaseModel):
    """A model that knows all its keys and never changes."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def read_config(path: Path, model: type[Model], context: Any = None) -> Model:
    """What a file says, checked.

    Args:
        path: a YAML file.
        model: what it must be.
        context: for the validators of the model, as `ValidationInfo.context`.

    Raises:
        ConfigError: it cannot be read, is not YAML, or says something that the model forbids.
    """
    try:
        text = path.read_text(encoding="utf-8")
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        return model.model_validate(yaml.safe_load(text), context=context)
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read: {error}") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{mark.line + 1}:{mark.column + 1}" if mark else "1:1"
        raise ConfigError(f"{path}:{where}: not YAML: {error.problem}") from error
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: not YAML: {str(error).splitlines()[0]}") from error
    except ValidationError as error:
        raise ConfigError(f"{path}:{_explain(node, _worst(error), model)}") from error


def _worst(error: ValidationError) -> Any:
    """The objection to report: a misspelled key rather than the one that is missing for it."""
    errors = error.errors()
    return next((one for one in errors if one["type"] == "extra_forbidden"), errors[0])


def _explain(root: yaml.Node | None, error: Any, model: type[BaseModel]) -> str:
    """One line for what pydantic objects to: where it stands, what is wrong, how to fix it."""
    location, kind = error["loc"], error["type"]
    line, column, holder = _locate(root, location)
    where = f"{line}:{column}: {'.'.join(str(key) for key in location) or 'the file'}"
    if kind == "extra_forbidden":
        return f"{where}: unknown key; {suggest(str(location[-1]), _keys(model, location[:-1]))}"
    if kind == "missing":
        return f"{where}: is missing: add it under {holder}"
    message = error["msg"].removeprefix("Value error, ")
    named = isinstance(error["input"], dict) or f"`{error['input']}`" in message
    given = "" if named else f", not {error['input']!r}"
    return f"{where}: {message[:1].lower()}{message[1:]}{given}"


def _locate(root: yaml.Node | None, location: tuple[int | str, ...]) -> tuple[int, int, str]:
    """Line and column of the deepest node on the way to a location, and that node's key."""
    node, mark, holder = root, root.start_mark if root else None, "the top level"
    for key in location:
        if isinstance(node, yaml.MappingNode):
            found = next((entry for entry in node.value if entry[0].value == key), None)
            if found is None:
                break
            mark, node, holder = found[0].start_mark, found[1], str(key)
        elif isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
            node = node.value[key]
            mark = node.start_mark
    return (mark.line + 1, mark.column + 1, holder) if mark else (1, 1, holder)


def _keys(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """The keys that are known at a location."""
    for key in location:
        if isinstance(key, str):
            annotation = model.model_fields[key].annotation
            for inner in (annotation, *get_args(annotation)):
                if isinstance(inner, type) and issubclass(inner, BaseModel):
                    model = inner
    return list(model.model_fields)
