"""A task file taken apart into its sections, before its parameters have values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from trees.language.diagnostics import Diagnostics
from trees.language.parameters import TaskParameter, read_parameters
from trees.language.source import Entry, Scalar, compose, read_text
from trees.language.syntax import TaskOutput
from trees.language.tables import WORD, fields, named_entries
from trees.language.values import describe


@dataclass(frozen=True, kw_only=True)
class Document:
    """The sections of a file, and what it says of itself."""

    path: Path
    text: str
    name: str
    description: str
    scene: str
    parameters: Mapping[str, TaskParameter]
    outputs: Mapping[str, TaskOutput]
    sections: Mapping[str, Entry]
    """`poses`, `regions` and `tree`, as far as they are there."""
    params: Entry | None
    """The section of the parameters."""


SECTIONS = ("poses", "regions", "tree")
"""Where `$name` may stand."""

FILE_KEYS: Mapping[str, str] = {
    "task": "The name of the task.",
    "description": "What it does, for people.",
    "scene": "The simulated scene that it is written for.",
    "params": "What may be chosen from outside, each with a type or a default.",
    "outputs": "Keys that a file with this subtree may take over, each with what it means.",
    "poses": "Places of hand, base and arm by name, in metres and degrees.",
    "regions": "Boxes in the world by name, in metres and degrees.",
    "tree": "The root of the tree: a single node.",
}
"""What may stand in a task file, with a line about each."""


def read_document(diagnostics: Diagnostics) -> Document | None:
    """The sections of the file that the diagnostics are about; None if it has none to read."""
    text = read_text(diagnostics.path, diagnostics)
    document = None if text is None else compose(text, diagnostics)
    if text is None or document is None:
        return None
    required = ("task", "tree")
    optional = [key for key in FILE_KEYS if key not in required]
    entries = fields(document, "the file", diagnostics, required=required, optional=optional)
    if entries is None:
        return None
    texts = {
        key: _text(entries[key], key, diagnostics) if key in entries else ""
        for key in ("task", "description", "scene")
    }
    if texts["task"] and not WORD.fullmatch(texts["task"]):
        hint = "use letters, digits and `_`, and begin with a letter"
        what = f"`{texts['task']}` cannot name a task"
        diagnostics.error(entries["task"].value.place, what, hint)
    params = entries.get("params")
    parameters = read_parameters(params, diagnostics)
    return Document(
        path=diagnostics.path,
        text=text,
        name=texts["task"],
        description=texts["description"],
        scene=texts["scene"],
        parameters=parameters,
        outputs=_read_outputs(entries.get("outputs"), parameters, diagnostics),
        sections={key: entries[key] for key in SECTIONS if key in entries},
        params=params,
    )


def _read_outputs(
    entry: Entry | None, parameters: Mapping[str, TaskParameter], diagnostics: Diagnostics
) -> dict[str, TaskOutput]:
    outputs = {}
    for name, place, value in named_entries(entry, "outputs", diagnostics):
        text = value.value if isinstance(value, Scalar) else value
        if name in parameters:
            what = f"`{name}` is a parameter, and cannot be written to"
            diagnostics.error(place, what, "choose another name for the key")
        elif text is None or isinstance(text, str):
            outputs[name] = TaskOutput(place=place, description=text or "")
        else:
            what = f"the output `{name}` is described by a text, not {describe(value)}"
            diagnostics.error(value.place, what, "say what it means")
    return outputs


def _text(entry: Entry, key: str, diagnostics: Diagnostics) -> str:
    text = entry.value.value if isinstance(entry.value, Scalar) else None
    if isinstance(text, str) and text.strip():
        return text.strip()
    what = f"`{key}` is a text, not {describe(entry.value)}"
    diagnostics.error(entry.value.place, what, "write one")
    return ""
