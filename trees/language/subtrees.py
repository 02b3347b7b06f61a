"""The node `subtree`: finds the other file, gives it its parameters, and reads it.

A file is named relative to the one that includes it and lies in the folder of the task, or below;
links that lead out of it, and files that include themselves, are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import TypeAlias

from config import suggest
from trees.language.arguments import note_mismatch, read_key_name
from trees.language.diagnostics import Diagnostics, Location
from trees.language.documents import Document, read_document
from trees.language.parameters import TaskParameter
from trees.language.scope import Scope
from trees.language.source import Entry, Scalar, Table, Value
from trees.language.syntax import SubtreeNode, Task
from trees.language.tables import fields
from trees.language.values import Given, KeyRead, KeyWrite, MismatchError, convert, describe

MAX_SUBTREES = 200
"""In a whole task, every use of a file counted."""

Assemble: TypeAlias = (
    "Callable[[Document, Mapping[str, TaskParameter], Diagnostics, Subtrees], Task | None]"
)
"""(sections, parameters with values, diagnostics of the file, its subtrees) to the task."""


@dataclass(frozen=True, kw_only=True)
class Subtrees:
    """The files around one file of a task.

    Made for the first file by its own fields; `include` makes those for the others.
    """

    assemble: Assemble
    chain: tuple[Path, ...]
    """The files from the first to this one, as a person names them."""
    level: int = 0
    """How deep in the whole tree this file is."""
    documents: dict[Path, Document | None] = field(default_factory=dict)
    """Every file that was read, by its real path."""
    numbers: count[int] = field(default_factory=count)
    """Counts the subtrees of the task."""

    def include(self, entry: Entry, scope: Scope) -> SubtreeNode | None:
        """The node that stands for another file; None and diagnostics if it cannot be read."""
        hint = "write `subtree: {file: other.yaml}`"
        if not isinstance(entry.value, Table):
            what = f"`subtree` takes a mapping, not {describe(entry.value)}"
            scope.diagnostics.error(entry.place, what, hint)
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
        path = self._find(entries["file"].value, scope.diagnostics)
        if path is None:
            return None
        inner = scope.diagnostics.of(path)
        real = path.resolve()
        if real not in self.documents:
            self.documents[real] = read_document(inner)
        document = self.documents[real]
        if document is None:
            return None
        arguments = _read_with(entry.place, entries, document, scope)
        outputs = _read_out(entries.get("out"), document, scope)
        parameters = {
            name: replace(parameter, value=scope.known(arguments.get(name)))
            for name, parameter in document.parameters.items()
        }
        below = replace(self, chain=(*self.chain, path), level=scope.level)
        task = self.assemble(document, parameters, inner, below)
        if task is None:
            return None
        file = entries["file"].value
        assert isinstance(file, Scalar)
        return SubtreeNode(
            place=entry.place,
            name=task.name,
            modifiers={},
            file=str(file.value),
            task=task,
            arguments=arguments,
            outputs=outputs,
        )

    def _find(self, value: Value, diagnostics: Diagnostics) -> Path | None:
        """The file that is meant, if it may be; None and a diagnostic otherwise."""
        name = value.value if isinstance(value, Scalar) else None
        if not isinstance(name, str) or not name.isprintable() or not name.strip():
            diagnostics.error(value.place, f"`file` cannot be {describe(value)}", "name a file")
            return None
        folder = self.chain[0].parent
        path = self.chain[-1].parent / name
        try:
            real, inside = path.resolve(), folder.resolve()
            is_there = real.is_file()
            others = () if is_there else tuple(path.parent.glob("*.yaml"))
        except (OSError, RuntimeError):
            diagnostics.error(
                value.place, f"`{name}` leads nowhere", "name a file, or fix the link"
            )
            return None
        if Path(name).is_absolute() or not real.is_relative_to(inside):
            what = f"`{name}` leads out of the folder of the task"
            diagnostics.error(value.place, what, f"keep it in `{folder}` or below")
            return None
        if not is_there:
            known = {other.name for other in others} - {other.name for other in self.chain}
            near = suggest(path.name, known) if known else "check the path"
            diagnostics.error(value.place, f"there is no file `{name}` beside this one", near)
            return None
        around = [other.resolve() for other in self.chain]
        if real in around:
            circle = (*self.chain[around.index(real) :], path)
            names = " > ".join(other.name for other in circle)
            diagnostics.error(value.place, f"the files go round in a circle: {names}", "break it")
            return None
        number = next(self.numbers)
        if number == MAX_SUBTREES:
            what = f"the task has more than {MAX_SUBTREES} subtrees"
            diagnostics.error(value.place, what, "make it smaller")
        return path if number < MAX_SUBTREES else None


def _read_with(
    place: Location, entries: Mapping[str, Entry], document: Document, scope: Scope
) -> dict[str, Given]:
    """Values of the other file's parameters."""
    arguments: dict[str, Given] = {}
    given = _table(entries.get("with"), "with", "{parameter: value}", scope)
    if given is None:
        return arguments
    for name, argument in given.items():
        parameter = document.parameters.get(name)
        if parameter is None:
            what = f"`{document.name}` has no parameter `{name}`"
            hint = suggest(name, document.parameters)
            scope.diagnostics.error(argument.place, what, hint)
            continue
        if parameter.type is None:
            continue
        try:
            value = convert(argument.value, parameter.type, scope.places.named)
        except MismatchError as mismatch:
            about = f" ({parameter.description})" if parameter.description else ""
            note_mismatch(argument.value, f"`{name}`{about}: {mismatch.what}", mismatch.hint, scope)
            continue
        if isinstance(scope.known(value), KeyRead) and parameter.type.is_bounded:
            what = f"`{name}` has bounds, and what `{value}` holds is known only during the run"
            scope.diagnostics.error(argument.value.place, what, "give a value")
            continue
        scope.use(value)
        arguments[name] = value
    for name, parameter in document.parameters.items():
        # One that stands beside `file` by diagnostic is noted there.
        is_needed = parameter.type is not None and parameter.default is None
        if is_needed and name not in {*given, *entries}:
            about = f": {parameter.description}" if parameter.description else ""
            what = f"`{document.name}` lacks `{name}` ({parameter.type}{about})"
            scope.diagnostics.error(place, what, f"write `with: {{{name}: ...}}` below `subtree`")
    return arguments


def _read_out(entry: Entry | None, document: Document, scope: Scope) -> dict[str, KeyWrite]:
    """Keys of the including file that take the outputs of the other."""
    outputs = {}
    given = _table(entry, "out", "{output: key}", scope) or {}
    for name, argument in given.items():
        if name in document.outputs:
            write = read_key_name(name, argument.value, scope)
            if write is not None:
                outputs[name] = write
        else:
            what = f"`{document.name}` has no output `{name}`"
            hint = suggest(name, document.outputs)
            scope.diagnostics.error(argument.place, what, hint)
    return outputs


def _table(entry: Entry | None, key: str, form: str, scope: Scope) -> Mapping[str, Entry] | None:
    """The entries below a key; None and a diagnostic if there is something else."""
    if entry is None or (isinstance(entry.value, Scalar) and entry.value.value is None):
        return {}
    if isinstance(entry.value, Table):
        return entry.value.entries
    what = f"`{key}` is a mapping, not {describe(entry.value)}"
    scope.diagnostics.error(entry.value.place, what, f"write `{key}: {form}`")
    return None
