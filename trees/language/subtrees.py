"""Syntax of the node `subtree`: the other file, its parameters and outputs.

The file is named relative to the including one and lies in the folder of the task, or below; links
that lead out of it, and files that include themselves, are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import TypeAlias

from config import (
    Diagnostics,
    Location,
    YamlEntry,
    YamlMap,
    YamlScalar,
    YamlValue,
    describe,
    suggest,
)
from trees.language.arguments import read_argument, read_key_name
from trees.language.documents import Document, read_document
from trees.language.mappings import fields
from trees.language.parameters import TaskParameter
from trees.language.scope import Scope
from trees.language.syntax import SubtreeNode, Task
from trees.language.values import Argument, KeyRead, KeyWrite

MAX_SUBTREES = 200
"""In a whole task, every use of a file counted."""

Assemble: TypeAlias = (
    "Callable[[Document, Mapping[str, TaskParameter], Diagnostics, Subtrees], Task | None]"
)
"""(sections, parameters with values, diagnostics of the file, its subtrees) to the task."""


@dataclass(frozen=True, kw_only=True)
class Subtrees:
    """Reads the files that one file of a task includes."""

    assemble: Assemble
    chain: tuple[Path, ...]
    """The files from the first to this one."""
    level: int = 0
    """How deep in the whole tree this file is."""
    documents: dict[Path, Document | None] = field(default_factory=dict)
    """Every file that was read, by its real path."""
    numbers: count[int] = field(default_factory=count)
    """Counts the subtrees of the task."""

    def include(self, entry: YamlEntry, scope: Scope) -> SubtreeNode | None:
        """The node for another file; None and errors if it cannot be read."""
        if not isinstance(entry.value, YamlMap):
            message = f"`subtree` takes a mapping, not {describe(entry.value)}"
            hint = "write `subtree: {file: other.yaml}`"
            scope.diagnostics.error(entry.location, message, hint)
            return None
        entries = fields(
            entry.value,
            "`subtree`",
            scope.diagnostics,
            required=("file",),
            optional=("with", "out"),
        )
        if entries is None:
            return None
        file = scope.text(entries["file"].value)
        path = self._find(file, entries["file"].value, scope.diagnostics)
        if path is None:
            return None
        inner = scope.diagnostics.of(path)
        real = path.resolve()
        if real not in self.documents:
            self.documents[real] = read_document(inner)
        document = self.documents[real]
        if document is None:
            return None
        arguments = _read_with(entry.location, entries, document, scope)
        outputs = _read_out(entries.get("out"), document, scope)
        parameters = {
            name: replace(parameter, value=scope.known(arguments.get(name)))
            for name, parameter in document.parameters.items()
        }
        below = replace(self, chain=(*self.chain, path), level=scope.level)
        task = self.assemble(document, parameters, inner, below)
        if task is None:
            return None
        return SubtreeNode(
            location=entry.location,
            name=task.name,
            modifiers={},
            file=str(file),
            task=task,
            arguments=arguments,
            outputs=outputs,
        )

    def _find(self, name: object, value: YamlValue, diagnostics: Diagnostics) -> Path | None:
        """The file of this name, if it may be included; None and an error otherwise."""
        if not isinstance(name, str) or not name.isprintable() or not name.strip():
            diagnostics.error(value.location, f"`file` cannot be {describe(value)}", "name a file")
            return None
        folder = self.chain[0].parent
        path = self.chain[-1].parent / name
        try:
            real, inside = path.resolve(), folder.resolve()
            is_there = real.is_file()
            others = () if is_there else tuple(path.parent.glob("*.yaml"))
        except (OSError, RuntimeError):
            diagnostics.error(
                value.location, f"`{name}` leads nowhere", "name a file, or fix the link"
            )
            return None
        if Path(name).is_absolute() or not real.is_relative_to(inside):
            message = f"`{name}` leads out of the folder of the task"
            diagnostics.error(value.location, message, f"keep it in `{folder}` or below")
            return None
        if not is_there:
            known = {other.name for other in others} - {other.name for other in self.chain}
            hint = suggest(path.name, known) if known else "check the path"
            diagnostics.error(value.location, f"there is no file `{name}` beside this one", hint)
            return None
        around = [other.resolve() for other in self.chain]
        if real in around:
            circle = (*self.chain[around.index(real) :], path)
            names = " > ".join(other.name for other in circle)
            message = f"the files include each other in a circle: {names}"
            diagnostics.error(value.location, message, "remove one of these subtrees")
            return None
        number = next(self.numbers)
        if number == MAX_SUBTREES:
            message = f"the task has more than {MAX_SUBTREES} subtrees"
            diagnostics.error(value.location, message, "make it smaller")
        return path if number < MAX_SUBTREES else None


def _read_with(
    location: Location, entries: Mapping[str, YamlEntry], document: Document, scope: Scope
) -> dict[str, Argument]:
    """Values of the other file's parameters."""
    arguments: dict[str, Argument] = {}
    given = _entries(entries.get("with"), "with", "{parameter: value}", scope)
    if given is None:
        return arguments
    for name, argument in given.items():
        parameter = document.parameters.get(name)
        if parameter is None:
            message = f"`{document.name}` has no parameter `{name}`"
            hint = suggest(name, document.parameters)
            scope.diagnostics.error(argument.location, message, hint)
            continue
        if parameter.type is None:
            continue
        read = read_argument(name, argument.value, parameter.type, parameter.description, scope)
        value = read.get(name)
        if isinstance(scope.known(value), KeyRead) and parameter.type.is_bounded:
            message = f"`{name}` has bounds, and `{value}` has its value only during the run"
            scope.diagnostics.error(argument.value.location, message, "give a value")
            continue
        arguments |= read
    for name, parameter in document.parameters.items():
        # One that stands beside `file` by mistake is noted there.
        is_needed = parameter.type is not None and parameter.default is None
        if is_needed and name not in {*given, *entries}:
            about = f": {parameter.description}" if parameter.description else ""
            message = f"`{document.name}` lacks `{name}` ({parameter.type}{about})"
            scope.diagnostics.error(
                location, message, f"write `with: {{{name}: ...}}` below `subtree`"
            )
    return arguments


def _read_out(entry: YamlEntry | None, document: Document, scope: Scope) -> dict[str, KeyWrite]:
    """Keys of the including file that take the outputs of the other."""
    outputs = {}
    given = _entries(entry, "out", "{output: key}", scope) or {}
    for name, argument in given.items():
        if name in document.outputs:
            write = read_key_name(name, argument.value, scope)
            if write is not None:
                outputs[name] = write
        else:
            message = f"`{document.name}` has no output `{name}`"
            hint = suggest(name, document.outputs)
            scope.diagnostics.error(argument.location, message, hint)
    return outputs


def _entries(
    entry: YamlEntry | None, key: str, form: str, scope: Scope
) -> Mapping[str, YamlEntry] | None:
    """The entries below a key; None and an error if there is something else."""
    if entry is None or (isinstance(entry.value, YamlScalar) and entry.value.value is None):
        return {}
    if isinstance(entry.value, YamlMap):
        return entry.value.entries
    message = f"`{key}` is a mapping, not {describe(entry.value)}"
    scope.diagnostics.error(entry.value.location, message, f"write `{key}: {form}`")
    return None
