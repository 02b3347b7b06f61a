"""Loading of task files: everything is read and checked in one pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from behaviours import BasePose, Posture, Region, ToolPose
from config import Diagnostic, Diagnostics, Location, TooManyErrorsError, YamlScalar
from trees.language.documents import Document, read_document
from trees.language.flow import check_flow
from trees.language.lint import lint
from trees.language.named_poses import NamedValues, read_named_values, read_site
from trees.language.parameters import TaskParameter, override_values, with_values
from trees.language.parse import read_node
from trees.language.registry import Installed
from trees.language.scope import Scope
from trees.language.subtrees import Subtrees
from trees.language.syntax import SCENE, Task, TaskFileError

if TYPE_CHECKING:
    from behaviours import Leaf

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

    Args:
        path: the file.
        leaves: what may stand in the tree; None is all that is installed.
        overrides: values of task parameters, as texts.
        places: a file of poses and regions, which count instead of those of the same name.
        open_parameters: whether every `$name` of a parameter stays in the tree as a `KeyRead`,
            whatever its default; the task can then be looked at, but not built.

    Raises:
        TaskFileError: with every diagnostic in the files.
        LeafError: a leaf class, not the file, is at fault.
    """
    mode = _Mode.OPEN if open_parameters else _Mode.RUN
    task, diagnostics = _read(Path(path), leaves, overrides, mode, places)
    if task is None:
        raise TaskFileError(diagnostics)
    return task


def check(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    places: Path | None = None,
) -> list[Diagnostic]:
    """Every diagnostic of a task file and its subtrees in order, up to a hundred errors.

    Parameters may lack a value. Arguments and LeafError as for `load`.
    """
    return examine(path, leaves=leaves, overrides=overrides, places=places)[1]


def examine(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    places: Path | None = None,
) -> tuple[Task | None, list[Diagnostic]]:
    """The task, None if there is an error, and the diagnostics of `check`."""
    return _read(Path(path), leaves, overrides, _Mode.CHECK, places)


class _Mode(Enum):
    """Treatment of the parameters of the first file."""

    RUN = "every one needs a value"
    CHECK = "one without a value is taken for any value of its type"
    OPEN = "each stays in the tree by its name"


def _read(
    path: Path,
    leaves: Mapping[str, type[Leaf]] | None,
    overrides: Mapping[str, str],
    mode: _Mode,
    places: Path | None,
) -> tuple[Task | None, list[Diagnostic]]:
    """The task, or None if there are errors; and all diagnostics in order."""
    assembler = _Assembler(known=Installed(leaves), open_tree=mode is _Mode.OPEN)
    diagnostics = Diagnostics(path, MAX_ERRORS)
    task = None
    try:
        site = None if places is None else (places, read_site(diagnostics.of(places)))
        assembler = replace(assembler, site=site)
        document = read_document(diagnostics)
        if document is not None:
            params = document.entries.get("params")
            given = override_values(document.parameters, overrides, params, diagnostics)
            if mode is _Mode.RUN:
                _require_values(document, given, diagnostics)
            subtrees = Subtrees(assemble=assembler.assemble, chain=(path,))
            task = assembler.assemble(document, document.parameters, diagnostics, subtrees, given)
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
            diagnostics.error(parameter.location, message, hint)


@dataclass(frozen=True, kw_only=True)
class _Assembler:
    """Makes a task of the sections of a file."""

    known: Installed
    open_tree: bool
    """Whether parameters stay in the tree by their names."""
    site: tuple[Path, NamedValues] | None = None
    """A file of poses and regions, for the first file of the task."""

    def assemble(
        self,
        document: Document,
        parameters: Mapping[str, TaskParameter],
        diagnostics: Diagnostics,
        subtrees: Subtrees,
        overrides: Mapping[str, YamlScalar] = MappingProxyType({}),
    ) -> Task | None:
        """The task in a file; None if there is an error in it or in any file before.

        Args:
            document: its sections.
            parameters: with the values that an including file gives.
            diagnostics: of the file.
            subtrees: reads the included files.
            overrides: values of a person.
        """
        entries = document.entries
        named = read_named_values(entries.get("poses"), entries.get("regions"), diagnostics)
        if self.site is not None and len(subtrees.chain) == 1:
            path, others = self.site
            named.take(others, path)
        declared = with_values(parameters, overrides, named, diagnostics)
        if self.open_tree:
            parameters = {name: replace(one, value=None) for name, one in declared.items()}
        else:
            parameters = declared
        scope = Scope(
            leaves=self.known.leaves,
            problems=self.known.problems,
            fetch=self.known.fetch,
            parameters=parameters,
            named=named,
            diagnostics=diagnostics,
            include=subtrees.include,
            level=subtrees.level,
        )
        for parameter in declared.values():
            scope.use(parameter.value)
            scope.used_values.add(str(parameter.default and parameter.default.value))
        root = read_node(entries["tree"].value, scope)
        if root is None or diagnostics.fatal:
            return None
        flow = check_flow(root, parameters, document.outputs, diagnostics)
        if flow is None:
            return None
        _warn_of_unused(scope)
        if not lint(root, flow.facts, diagnostics):
            return None
        return Task(
            name=document.name,
            description=document.description,
            path=diagnostics.path,
            text=document.text,
            scene=document.scene,
            parameters=parameters,
            poses=named.defined(ToolPose, BasePose, Posture),
            regions=named.defined(Region),
            locations=_locations(document, named),
            site=named.files,
            outputs=flow.outputs,
            root=root,
            outcomes=flow.outcomes,
        )


def _locations(document: Document, named: NamedValues) -> dict[str, Location]:
    """Of poses, regions and scene; `scene:` cannot be the name of a pose."""
    scene = document.entries.get("scene")
    return named.locations | ({SCENE: scene.value.location} if scene else {})


def _warn_of_unused(scope: Scope) -> None:
    warn = scope.diagnostics.warning
    for name, parameter in scope.parameters.items():
        if name not in scope.used_parameters:
            hint = f"write `${name}` somewhere, or remove it"
            warn(parameter.location, f"the parameter `{name}` is never used", hint)
    for name, location in scope.named.locations.items():
        if name not in scope.used_values and name not in scope.named.files:
            warn(location, f"`{name}` is never used", "name it in the tree, or remove it")
