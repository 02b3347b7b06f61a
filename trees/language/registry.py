"""The leaves that a task file may use: the project's own, and those of installed packages.

A broken package stops only the tasks that use it: whatever it does while it is imported, its
problem becomes a line of text. The project's own leaves are declared in a file, written by
`make declarations` from their classes, so that `check` need not import those.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, cached_property
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, NamedTuple

from config import PluginError, entries, imported
from trees.language.leaf_type import OWN_LEAVES, LeafType, Output, Parameter
from trees.words import TYPES_BY_NAME, ValueType

if TYPE_CHECKING:
    from importlib import metadata

    from behaviours import Leaf

ENTRY_POINTS = "frankie_task.behaviours"  # in which other packages offer their leaves
IMPORT_TIMEOUT = 20.0  # of a package [s]


class Offer(NamedTuple):
    """What one entry point offers: a leaf and its description, or a problem."""

    leaf: type[Leaf] | None
    type: LeafType | None
    problem: str  # in one line, with a hint; empty if there is none


@cache
def offer_of(entry: metadata.EntryPoint) -> Offer:
    """What an entry point offers, imported once in a process."""
    from behaviours import Leaf

    try:
        leaf = imported(entry, IMPORT_TIMEOUT)
        if not isinstance(leaf, type) or not issubclass(leaf, Leaf):
            return _broken(entry, "it is no class that derives from Leaf or Condition")
        return Offer(leaf, _described({leaf.key: leaf})[leaf.key], "")
    except PluginError as error:
        return _broken(entry, str(error))
    except Exception as error:  # of a class that anybody may have written
        return _broken(entry, str(error) or type(error).__name__)


def _broken(entry: metadata.EntryPoint, why: str) -> Offer:
    problem = (
        f"behaviour `{entry.name}` of `{entry.value}` cannot be used: "
        f"{' '.join(why.split())[:200]}; fix or uninstall its package"
    )
    return Offer(None, None, problem)


class Installed:
    """The leaves of this installation; packages are imported when their leaves are used.

    `leaves` are those besides packages; None is the project's own leaves, and packages.
    """

    def __init__(self, leaves: Mapping[str, type[Leaf]] | None = None) -> None:
        self._given = leaves
        self._fetched: dict[str, type[Leaf]] = {}
        self.leaves = declared_leaves() if leaves is None else _described(leaves)
        """By their keys: those of packages are added when they are fetched."""
        self.problems: dict[str, str] = {}
        """Of packages that cannot be used, in a line each, by the name of the entry point."""
        _found_problems.clear()

    @cached_property
    def _pending(self) -> list[metadata.EntryPoint]:
        return entries(ENTRY_POINTS) if self._given is None else []

    def fetch(self, name: str | None = None) -> None:
        """Import what packages offer by this name, or all that they offer."""
        for entry in [entry for entry in self._pending if name in (None, entry.name)]:
            self._pending.remove(entry)
            leaf, described, problem = offer_of(entry)
            if leaf is not None and leaf.key in self.leaves:
                problem = _broken(entry, f"it takes the key `{leaf.key}`, which is taken").problem
            if problem:
                self.problems[entry.name] = problem
            elif leaf is not None and described is not None:
                self._fetched[leaf.key], self.leaves[leaf.key] = leaf, described
        _found_problems.update(self.problems)

    @property
    def classes(self) -> dict[str, type[Leaf]]:
        """The classes of all leaves, by their keys."""
        from behaviours import LEAVES

        self.fetch()
        return dict(LEAVES if self._given is None else self._given) | self._fetched


_found_problems: dict[str, str] = {}


def plugin_problems() -> list[str]:
    """What is wrong with installed packages, as far as they were looked at: a line each."""
    return list(_found_problems.values())


def known_leaves() -> dict[str, type[Leaf]]:
    """The leaves that task files may use, by their keys: the project's own, and of packages."""
    return Installed().classes


def _described(leaves: Mapping[str, type[Leaf]]) -> dict[str, LeafType]:
    """What their classes say; most tasks need no class to be checked."""
    from trees.language.leaf_classes import describe_leaves

    return describe_leaves(leaves)


DECLARATIONS = Path(__file__).parent / "leaves.json"


def declared_leaves() -> dict[str, LeafType]:
    """The project's own leaves, by their keys, `set` and `add` among them."""
    written = json.loads(DECLARATIONS.read_text(encoding="utf-8"))
    return dict(OWN_LEAVES) | {one["key"]: _read_leaf(one) for one in written}


def declarations_text(leaves: Mapping[str, LeafType]) -> str:
    """The content of the file."""
    own = [leaf for key, leaf in leaves.items() if key not in OWN_LEAVES]
    return json.dumps(own, default=_written, indent=1, ensure_ascii=False) + "\n"


def _written(value: Any) -> object:
    """What JSON has no word for: types by name, classes of leaves and functions by place."""
    if isinstance(value, LeafType):
        return _fields(value) | {"behaviour": _place(value.behaviour)}
    if isinstance(value, type):
        return value.__name__
    return _fields(value) if is_dataclass(value) else _place(value)


def _fields(value: Any) -> dict[str, Any]:
    """The fields of a dataclass that are not what they are by default."""
    given = ((field, getattr(value, field.name)) for field in fields(value))
    return {field.name: one for field, one in given if one != field.default and one != {}}


def _deferred(where: str) -> Callable[..., Any]:
    """A class or function `package.module:name` that is imported when it is called."""
    return lambda *args, **named: resolve_name(where)(*args, **named)


def _place(value: Any) -> str:
    return f"{value.__module__}:{value.__qualname__}"


def _read_leaf(written: dict[str, Any]) -> LeafType:
    tuples = {name: tuple(value) for name, value in written.items() if isinstance(value, list)}
    read = {
        "behaviour": _deferred(written["behaviour"]),
        "validate": _deferred(written["validate"]) if "validate" in written else None,
        "parameters": _read_each(Parameter, written.get("parameters", {})),
        "outputs": _read_each(Output, written.get("outputs", {})),
    }
    return LeafType(**(written | tuples | read))


def _read_each(kind: type[Any], written: dict[str, dict[str, Any]]) -> dict[str, Any]:
    each = ((name, one | {"type": _read_type(one["type"])}) for name, one in written.items())
    return {name: kind(**one) for name, one in each}


def _read_type(written: dict[str, Any]) -> ValueType:
    types = tuple(TYPES_BY_NAME[name] for name in written["types"])
    return ValueType(**(written | {"types": types, "choices": tuple(written.get("choices", ()))}))
