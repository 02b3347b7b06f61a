"""From a file to a task: everything is read and checked in one pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from trees.language.documents import Document, read_document
from trees.language.flow import check_keys
from trees.language.lint import lint
from trees.language.mistakes import Mistake, Mistakes, TaskFileError
from trees.language.parameters import (
    TaskParameter,
    given_texts,
    substitute,
    with_values,
)
from trees.language.parse import read_node
from trees.language.places import read_places
from trees.language.registry import LeafType, describe_leaves, known_leaves
from trees.language.scope import Scope
from trees.language.source import Entry, Scalar
from trees.language.subtrees import Subtrees
from trees.language.task import Task

if TYPE_CHECKING:
    from behaviours.leaf import Leaf

NO_OVERRIDES: Mapping[str, str] = MappingProxyType({})


def load(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] = NO_OVERRIDES,
    open_parameters: bool = False,
) -> Task:
    """Read a task file and its subtrees.

    Args:
        path: the file.
        leaves: what may stand in the tree; None is all that is installed.
        overrides: values of task parameters, as texts.
        open_parameters: whether every `$name` of a parameter stays in the tree as a `KeyRead`,
            whatever its default; the task can then be looked at, but not built.

    Raises:
        TaskFileError: with every mistake in the files.
        LeafError: a leaf class, not the file, is at fault.
    """
    mistakes = Mistakes(Path(path))
    task = _read(
        mistakes, leaves, overrides, need_values=not open_parameters, open_tree=open_parameters
    )
    if task is None:
        raise TaskFileError(mistakes.in_order())
    return task


def check(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] = NO_OVERRIDES,
) -> list[Mistake]:
    """Every mistake of a task file and its subtrees, warnings included, in order.

    Parameters may lack a value. Arguments and LeafError as for `load`.
    """
    mistakes = Mistakes(Path(path))
    _read(mistakes, leaves, overrides, need_values=False, open_tree=False)
    return mistakes.in_order()


def _read(
    mistakes: Mistakes,
    leaves: Mapping[str, type[Leaf]] | None,
    overrides: Mapping[str, str],
    *,
    need_values: bool,
    open_tree: bool,
) -> Task | None:
    """The task, or None if there are errors."""
    assembler = _Assembler(
        leaves=describe_leaves(known_leaves() if leaves is None else leaves), open_tree=open_tree
    )
    document = read_document(mistakes)
    if document is None:
        return None
    given = given_texts(document.parameters, overrides, document.params, mistakes)
    if need_values:
        _require_values(document, given, mistakes)
    subtrees = Subtrees(assemble=assembler.assemble, chain=(mistakes.path,))
    task = assembler.assemble(document, document.parameters, mistakes, subtrees, given)
    return task and replace(task, warnings=tuple(mistakes.in_order()))


def _require_values(document: Document, given: Mapping[str, Scalar], mistakes: Mistakes) -> None:
    for name, parameter in document.parameters.items():
        if parameter.type is not None and parameter.default is None and name not in given:
            about = f": {parameter.description}" if parameter.description else ""
            what = f"the parameter `{name}` has no value ({parameter.type}{about})"
            mistakes.error(parameter.place, what, f"give `-p {name}=...`, or a `default` here")


@dataclass(frozen=True, kw_only=True)
class _Assembler:
    """Makes tasks of the sections of files."""

    leaves: Mapping[str, LeafType]
    open_tree: bool
    """Whether parameters stay in the tree by their names."""

    def assemble(
        self,
        document: Document,
        parameters: Mapping[str, TaskParameter],
        mistakes: Mistakes,
        subtrees: Subtrees,
        given: Mapping[str, Scalar] = MappingProxyType({}),
    ) -> Task | None:
        """The task in a file; None if there is an error in it or in any file before.

        Args:
            document: its sections.
            parameters: with the values that an including file gives.
            mistakes: of the file.
            subtrees: reads the files that it includes.
            given: values by a person, as the file would write them.
        """
        used: set[str] = set()

        def resolved(key: str) -> Entry | None:
            entry = document.sections.get(key)
            if entry is None:
                return None
            keys = key == "tree"
            value = substitute(entry.value, parameters, used, mistakes, keys=keys)
            return replace(entry, value=value)

        # Poses may be made of plain parameters, and parameters may be poses.
        parameters = with_values(parameters, given, None, mistakes)
        places = read_places(resolved("poses"), resolved("regions"), mistakes)
        parameters = with_values(parameters, given, places.named, mistakes)
        declared = parameters
        if self.open_tree:
            parameters = {name: replace(one, value=None) for name, one in declared.items()}
        scope = Scope(
            leaves=self.leaves,
            parameters=parameters,
            places=places,
            mistakes=mistakes,
            include=subtrees.include,
        )
        for parameter in declared.values():
            scope.use(parameter.value)
            scope.used.add(str(parameter.default and parameter.default.value))
        tree = resolved("tree")
        root = None if tree is None else read_node(tree.value, scope)
        if root is None or mistakes.fatal:
            return None
        outputs = check_keys(root, parameters, document.outputs, mistakes)
        if outputs is None:
            return None
        _warn_of_unused(parameters, used, scope)
        lint(root, mistakes)
        defined = {name: places.named[name] for name in places.defined}
        return Task(
            name=document.name,
            description=document.description,
            path=document.path,
            text=document.text,
            scene=document.scene,
            parameters=parameters,
            poses={key: thing for key, thing in defined.items() if key not in places.regions},
            regions={key: thing for key, thing in defined.items() if key in places.regions},
            outputs=outputs,
            root=root,
        )


def _warn_of_unused(parameters: Mapping[str, TaskParameter], used: set[str], scope: Scope) -> None:
    for name, parameter in parameters.items():
        if name not in used:
            what = f"the parameter `{name}` is never used"
            scope.mistakes.warning(
                parameter.place, what, f"write `${name}` somewhere, or remove it"
            )
    for name, place in scope.places.defined.items():
        if name not in scope.used:
            scope.mistakes.warning(
                place, f"`{name}` is never used", "name it in the tree, or remove it"
            )
