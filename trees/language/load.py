"""From a file to a task: everything is read and checked in one pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from py_trees.behaviour import Behaviour

from trees.language.build import build
from trees.language.mistakes import Mistake, Mistakes, TaskFileError
from trees.language.parameters import TaskParameter, read_parameters, substitute
from trees.language.parse import Scope, read_node
from trees.language.places import read_places
from trees.language.registry import describe_leaves, known_leaves
from trees.language.source import Entry, Plain, Scalar, compose, read_text
from trees.language.syntax import Node
from trees.language.tables import WORD, fields
from trees.language.values import describe

if TYPE_CHECKING:
    from behaviours.context import Context
    from behaviours.leaf import Leaf

NO_OVERRIDES: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Task:
    """A task file without mistakes."""

    name: str
    description: str
    path: Path
    text: str
    """The file as it was read."""
    parameters: Mapping[str, Plain]
    """Values by name, overrides included."""
    tree: Node
    warnings: tuple[Mistake, ...] = ()
    """What is probably not meant, and does not keep the task from running."""

    def build(self, context: Context) -> Behaviour:
        """A fresh tree, ready to tick, on the context's clock.

        Raises:
            TaskFileError: a leaf refused its parameters.
        """
        return build(self.tree, context, self.path)


def load(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] = NO_OVERRIDES,
) -> Task:
    """Read a task file.

    Args:
        path: the file.
        leaves: what may stand in the tree; None is all that is installed.
        overrides: values of task parameters, as texts.

    Raises:
        TaskFileError: with every mistake in the file.
        LeafError: a leaf class, not the file, is at fault.
    """
    mistakes = Mistakes(Path(path))
    task = _read(mistakes, known_leaves() if leaves is None else leaves, overrides)
    if task is None:
        raise TaskFileError(mistakes.in_order())
    return task


def check(
    path: Path | str,
    *,
    leaves: Mapping[str, type[Leaf]] | None = None,
    overrides: Mapping[str, str] = NO_OVERRIDES,
) -> list[Mistake]:
    """Every mistake of a task file, warnings included, in its order; empty when it is sound.

    Arguments and LeafError as for `load`.
    """
    mistakes = Mistakes(Path(path))
    _read(mistakes, known_leaves() if leaves is None else leaves, overrides)
    return mistakes.in_order()


def _read(
    mistakes: Mistakes, leaves: Mapping[str, type[Leaf]], overrides: Mapping[str, str]
) -> Task | None:
    """The task, or None if there are errors."""
    leaf_types = describe_leaves(leaves)
    text = read_text(mistakes.path, mistakes)
    document = None if text is None else compose(text, mistakes)
    if text is None or document is None:
        return None
    optional = ("description", "params", "poses", "regions")
    entries = fields(document, "the file", mistakes, required=("task", "tree"), optional=optional)
    if entries is None:
        return None

    parameters = read_parameters(entries.get("params"), overrides, mistakes)
    used: set[str] = set()
    resolved = {
        key: Entry(place=entry.place, value=substitute(entry.value, parameters, used, mistakes))
        for key, entry in entries.items()
        if key in ("poses", "regions", "tree")
    }
    places = read_places(resolved.get("poses"), resolved.get("regions"), mistakes)
    scope = Scope(leaves=leaf_types, places=places, mistakes=mistakes)
    tree = read_node(resolved["tree"].value, scope)
    name = _text(entries["task"], "task", mistakes)
    if name and not WORD.fullmatch(name):
        mend = "use letters, digits and `_`, and begin with a letter"
        mistakes.error(entries["task"].value.place, f"`{name}` cannot name a task", mend)
    description = (
        _text(entries["description"], "description", mistakes) if "description" in entries else ""
    )

    if tree is None or mistakes.fatal:
        return None
    _warn_of_unused(parameters, used, scope)
    return Task(
        name=name,
        description=description,
        path=mistakes.path,
        text=text,
        parameters={key: parameter.value for key, parameter in parameters.items()},
        tree=tree,
        warnings=tuple(mistakes.in_order()),
    )


def _text(entry: Entry, key: str, mistakes: Mistakes) -> str:
    text = entry.value.value if isinstance(entry.value, Scalar) else None
    if isinstance(text, str) and text.strip():
        return text.strip()
    mistakes.error(
        entry.value.place, f"`{key}` is a text, not {describe(entry.value)}", "write one"
    )
    return ""


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
