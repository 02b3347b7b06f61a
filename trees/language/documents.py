"""Sections of a task file, before its parameters have values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

from pydantic import AfterValidator, StringConstraints

from config import (
    Diagnostics,
    StrictModel,
    YamlEntry,
    YamlMap,
    YamlScalar,
    describe,
    read_yaml,
    validate,
)
from trees.language.mappings import NAMING_HINT, WORD, fields, named_entries
from trees.language.parameters import TaskParameter, read_parameters
from trees.language.syntax import TaskOutput

FILE_KEYS: Mapping[str, str] = {
    "task": "The name of the task.",
    "description": "What it does, for people.",
    "scene": "The simulated scene that it is written for.",
    "params": "What may be chosen from outside, each with a type or a default.",
    "outputs": "Keys that an including file may read, each with its meaning.",
    "poses": "Poses of hand, base and arm by name, in metres and degrees.",
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


@dataclass(frozen=True, kw_only=True)
class Document:
    """The sections of a file."""

    text: str
    name: str
    description: str
    scene: str
    parameters: Mapping[str, TaskParameter]
    outputs: Mapping[str, TaskOutput]
    entries: Mapping[str, YamlEntry]
    """All sections as they were read."""


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
    parameters = read_parameters(entries.get("params"), diagnostics)
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
            diagnostics.error(location, message, "choose another name for the key")
        elif text is None or isinstance(text, str):
            outputs[name] = TaskOutput(location=location, description=text or "")
        else:
            message = f"the output `{name}` is described by a text, not {describe(value)}"
            diagnostics.error(value.location, message, "write what it means")
    return outputs
