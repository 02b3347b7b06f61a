"""Loading of task files: everything is read and checked in one pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from types import MappingProxyType

from behaviours import BasePose, Leaf, Posture, Region, ToolPose
from config import (
    Diagnostic,
    Diagnostics,
    Location,
    TooManyErrorsError,
    YamlEntry,
    YamlMap,
    YamlScalar,
    describe,
)
from trees.language import rules
from trees.language.documents import Document, TaskParameter, read_document
from trees.language.flow import check_flow
from trees.language.lint import lint
from trees.language.mappings import fields
from trees.language.named_poses import NamedValues, read_named_values, read_site
from trees.language.parse import read_node
from trees.language.registry import Installed
from trees.language.scope import Scope
from trees.language.subtrees import find_file, override_values, read_out, read_with, with_values
from trees.language.syntax import SCENE, SubtreeNode, Task, TaskFileError

MAX_SUBTREES = 200  # in a whole task, every use of a file counted
MAX_ERRORS = 100  # after which reading stops

NO_OVERRIDES: Mapping[str, str] = MappingProxyType({})


def load(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    places: Path | None = None,
    open_parameters: bool = False,
) -> Task:
    """Read a task file and its subtrees.

    `leaves` may stand in the tree, None is all that is installed; `overrides` are values of
    parameters as texts; the poses and regions of the file `places` count instead of those of the
    same name. With `open_parameters` every `$name` of a parameter stays in the tree as a `KeyRead`:
    the task can then be looked at, but not built. Raises TaskFileError: with every diagnostic in
    the files; LeafError: a leaf class, not the file, is at fault.
    """
    task, diagnostics = examine(
        path, leaves=leaves, overrides=overrides, places=places, open_parameters=open_parameters
    )
    if task is None:
        raise TaskFileError(diagnostics)
    return task


def examine(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] | None = None,
    places: Path | None = None,
    open_parameters: bool = False,
    text: str | None = None,
) -> tuple[Task | None, list[Diagnostic]]:
    """The task, None if there is an error, and the diagnostics of it and its subtrees in order.

    There are a hundred errors at the most. Arguments and LeafError as for `load`; `text` is read
    instead of what the file contains. Without `overrides`, which are given for a run, a parameter
    may lack a value, and is taken for any of its type.
    """
    path = Path(path)
    known, diagnostics = Installed(leaves), Diagnostics(path, MAX_ERRORS, text)
    task = None
    try:
        site = None if places is None else (places, read_site(diagnostics.of(places)))
        document = read_document(diagnostics)
        if document is not None:
            params = document.entries.get("params")
            given = override_values(document.parameters, overrides or {}, params, diagnostics)
            if overrides is not None and not open_parameters:
                _require_values(document, given, diagnostics)
            reader = _Reader(known=known, open_tree=open_parameters, chain=(path,), site=site)
            task = reader.assemble(document, document.parameters, diagnostics, given)
    except TooManyErrorsError:
        pass
    found = diagnostics.in_order()
    return task and replace(task, warnings=tuple(found)), found


def _require_values(
    document: Document, overrides: Mapping[str, YamlScalar], diagnostics: Diagnostics
) -> None:
    for name, parameter in document.parameters.items():
        if parameter.type is not None and parameter.default is None and name not in overrides:
            about = f": {parameter.description}" if parameter.description else ""
            message = f"the parameter `{name}` has no value ({parameter.type}{about})"
            hint = f"give `-p {name}=...`, or a `default` here"
            diagnostics.error(rules.REFERENCE, parameter.location, message, hint)


@dataclass(frozen=True, kw_only=True)
class _Reader:
    """Makes a task of the sections of one file, and reads the files that it includes."""

    known: Installed
    open_tree: bool  # whether parameters stay in the tree by their names
    chain: tuple[Path, ...]  # the files from the first to this one
    site: tuple[Path, NamedValues] | None = None
    """A file of poses and regions, for the first file of the task."""
    level: int = 0  # how deep in the whole tree this file is
    documents: dict[Path, Document | None] = field(default_factory=dict)
    """Every included file that was read, by its real path."""
    numbers: count[int] = field(default_factory=count)  # counts the subtrees of the task

    def assemble(
        self,
        document: Document,
        parameters: Mapping[str, TaskParameter],
        diagnostics: Diagnostics,
        overrides: Mapping[str, YamlScalar] = MappingProxyType({}),
    ) -> Task | None:
        """The task in a file; None if there is an error in it or in any file before.

        `parameters` have the values that an including file gives, `overrides` are those of a
        person.
        """
        entries = document.entries
        named = read_named_values(entries.get("poses"), entries.get("regions"), diagnostics)
        if self.site is not None:
            path, others = self.site
            named.take(others, path)
        declared = parameters = with_values(parameters, overrides, named, diagnostics)
        if self.open_tree:
            parameters = {name: replace(one, value=None) for name, one in declared.items()}
        scope = Scope(
            known=self.known,
            parameters=parameters,
            named=named,
            diagnostics=diagnostics,
            include=self.include,
            level=self.level,
        )
        for parameter in declared.values():
            scope.use(parameter.value)
            scope.used_values.add(str(parameter.default and parameter.default.value))
        root = read_node(entries["tree"].value, scope)
        if root is None or diagnostics.fatal:
            return None
        is_first = len(self.chain) == 1
        flow = check_flow(root, parameters, document.outputs, diagnostics, is_first)
        if flow is None:
            return None
        _warn_of_unused(scope)
        if not lint(root, flow, diagnostics, is_first):
            return None
        # `scene:` cannot be the name of a pose.
        scene = {SCENE: entries["scene"].value.location} if "scene" in entries else {}
        return Task(
            name=document.name,
            description=document.description,
            path=diagnostics.path,
            text=document.text,
            scene=document.scene,
            parameters=parameters,
            poses=named.defined(ToolPose, BasePose, Posture),
            regions=named.defined(Region),
            locations=named.locations | scene,
            site=named.files,
            outputs=flow.outputs,
            root=root,
            outcomes=flow.outcomes,
        )

    def include(self, entry: YamlEntry, scope: Scope) -> SubtreeNode | None:
        """The node for another file; None and errors if it cannot be read."""
        if not isinstance(entry.value, YamlMap):
            message = f"`subtree` takes a mapping, not {describe(entry.value)}"
            hint = "write `subtree: {file: other.yaml}`"
            scope.error(rules.VALUE, entry.location, message, hint)
            return None
        optional = ("with", "out")
        entries = fields(
            entry.value, "`subtree`", scope.diagnostics, required=("file",), optional=optional
        )
        if entries is None:
            return None
        file = scope.text(entries["file"].value)
        path = find_file(file, entries["file"].value, self.chain, scope.diagnostics)
        if path is None or not self._has_room(entries["file"].value.location, scope.diagnostics):
            return None
        inner, real = scope.diagnostics.of(path), path.resolve()
        if real not in self.documents:
            self.documents[real] = read_document(inner)
        document = self.documents[real]
        if document is None:
            return None
        arguments = read_with(entry.location, entries, document, scope)
        outputs = read_out(entries.get("out"), document, scope)
        parameters = {
            name: replace(parameter, value=scope.if_known(arguments.get(name)))
            for name, parameter in document.parameters.items()
        }
        below = replace(self, chain=(*self.chain, path), level=scope.level, site=None)
        task = below.assemble(document, parameters, inner)
        if task is None:
            return None
        return SubtreeNode(
            location=entry.location,
            name=task.name,
            file=str(file),
            task=task,
            arguments=arguments,
            outputs=outputs,
        )

    def _has_room(self, location: Location, diagnostics: Diagnostics) -> bool:
        """Whether the task may have one more subtree."""
        number = next(self.numbers)
        if number == MAX_SUBTREES:
            message = f"the task has more than {MAX_SUBTREES} subtrees"
            diagnostics.error(rules.SIZE, location, message, "make it smaller")
        return number < MAX_SUBTREES


def _warn_of_unused(scope: Scope) -> None:
    warn = scope.diagnostics.warning
    for name, parameter in scope.parameters.items():
        if name not in scope.used_parameters:
            hint = f"write `${name}` somewhere, or remove it"
            warn(rules.UNUSED, parameter.location, f"the parameter `{name}` is never used", hint)
    for name, location in scope.named.locations.items():
        if name not in scope.used_values and name not in scope.named.files:
            hint = "name it in the tree, or remove it"
            warn(rules.UNUSED, location, f"`{name}` is never used", hint)
