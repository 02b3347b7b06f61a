"""The leaves that a task file may use: the project's own, and those of installed packages.

A broken package stops only the tasks that use it: whatever it does while it is imported, its
problem becomes a line of text.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, cached_property
from importlib.metadata import EntryPoint

from behaviours import LEAVES, Leaf
from config import entries, imported
from trees.language.leaf_classes import describe_leaves
from trees.language.leaf_type import LeafType

ENTRY_POINTS = "frankie_task.behaviours"  # in which other packages offer their leaves
IMPORT_TIMEOUT = 20.0  # of a package [s]


@cache
def offer_of(entry: EntryPoint) -> tuple[type[Leaf], LeafType] | str:
    """The leaf that an entry point offers and its description, or its problem in a line.

    It is imported once in a process.
    """
    try:
        leaf = imported(entry, IMPORT_TIMEOUT)
        if isinstance(leaf, type) and issubclass(leaf, Leaf):
            return leaf, describe_leaves({leaf.key: leaf})[leaf.key]
        why = "it is no class that derives from Leaf or Condition"
    except Exception as error:  # of a class that anybody may have written
        why = str(error) or type(error).__name__
    return _problem(entry, why)


def _problem(entry: EntryPoint, why: str) -> str:
    return (
        f"behaviour `{entry.name}` of `{entry.value}` cannot be used: "
        f"{' '.join(why.split())[:200]}; fix or uninstall its package"
    )


class Installed:
    """The leaves of this installation; packages are imported when their leaves are used.

    `leaves` are those besides packages; None is the project's own leaves, and packages.
    """

    def __init__(self, leaves: Mapping[str, type[Leaf]] | None = None) -> None:
        self._has_packages = leaves is None
        self._classes = dict(LEAVES if leaves is None else leaves)
        self.leaves = describe_leaves(self._classes)
        """By their keys: those of packages are added when they are fetched."""
        self.problems = _found_problems
        """Of packages that cannot be used, in a line each, by the name of the entry point."""
        self.problems.clear()

    @cached_property
    def _pending(self) -> list[EntryPoint]:
        return entries(ENTRY_POINTS) if self._has_packages else []

    def fetch(self, name: str | None = None) -> None:
        """Import what packages offer by this name, or all that they offer."""
        for entry in [entry for entry in self._pending if name in (None, entry.name)]:
            self._pending.remove(entry)
            offer = offer_of(entry)
            if not isinstance(offer, str) and (key := offer[0].key) in self.leaves:
                offer = _problem(entry, f"it takes the key `{key}`, which is taken")
            if isinstance(offer, str):
                self.problems[entry.name] = offer
            else:
                self._classes[key], self.leaves[key] = offer

    @property
    def classes(self) -> dict[str, type[Leaf]]:
        """The classes of all leaves, by their keys."""
        self.fetch()
        return self._classes


_found_problems: dict[str, str] = {}


def plugin_problems() -> list[str]:
    """What is wrong with installed packages, as far as they were looked at: a line each."""
    return list(_found_problems.values())


def known_leaves() -> dict[str, type[Leaf]]:
    """The leaves that task files may use, by their keys: the project's own, and of packages."""
    return Installed().classes
