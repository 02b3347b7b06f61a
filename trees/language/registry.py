"""The leaves that a task file may use: the project's own, and those of installed packages.

A broken package stops only the tasks that use it: whatever it does while it is imported, its
problem becomes a line of text.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

from config import PluginError, entries, imported
from trees.language.declarations import declared_leaves
from trees.language.leaf_type import LeafType

if TYPE_CHECKING:
    from importlib import metadata

    from behaviours import Leaf

ENTRY_POINTS = "frankie_task.behaviours"
"""Entry-point group in which other packages offer their leaves."""
IMPORT_TIMEOUT = 20.0
"""Of a package [s]."""


@dataclass(frozen=True, kw_only=True)
class Offer:
    """What one entry point offers."""

    name: str
    """Of the entry point; by custom the key of the leaf."""
    value: str
    """Where it is, as `package:Class`."""
    leaf: type[Leaf] | None = None
    """None if it cannot be used."""
    problem: str = ""
    """In one line, with a hint; empty if there is none."""

    def broken(self, why: str) -> Offer:
        """The same offer with a problem instead of a leaf."""
        problem = (
            f"behaviour `{self.name}` of `{self.value}` cannot be used: "
            f"{' '.join(why.split())[:200]}; fix or uninstall its package"
        )
        return Offer(name=self.name, value=self.value, problem=problem)


@cache
def offer_of(entry: metadata.EntryPoint) -> Offer:
    """The leaf of an entry point, imported once in a process."""
    from behaviours import Leaf

    offer = Offer(name=entry.name, value=entry.value)
    try:
        leaf = imported(entry, IMPORT_TIMEOUT)
    except PluginError as error:
        return offer.broken(str(error))
    if not isinstance(leaf, type) or not issubclass(leaf, Leaf):
        return offer.broken("it is no class that derives from Leaf or Condition")
    return Offer(name=entry.name, value=entry.value, leaf=leaf)


class Installed:
    """The leaves of this installation; packages are imported when their leaves are used.

    Args:
        leaves: what there is besides packages; None is the project's own leaves, and packages.
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
        wanted = [entry for entry in self._pending if name in (None, entry.name)]
        for entry in wanted:
            self._pending.remove(entry)
            usable = _checked(offer_of(entry), self.leaves)
            if usable.leaf is None:
                self.problems[usable.name] = usable.problem
            else:
                self._fetched[usable.leaf.key] = usable.leaf
                self.leaves |= _described({usable.leaf.key: usable.leaf})
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


def _checked(offer: Offer, taken: Iterable[str]) -> Offer:
    """The offer, with a problem if its leaf does not keep to the contract."""
    if offer.leaf is None:
        return offer
    try:
        if offer.leaf.key in taken:
            return offer.broken(f"it takes the key `{offer.leaf.key}`, which is taken")
        _described({offer.leaf.key: offer.leaf})
    except Exception as error:  # of a class that anybody may have written
        return offer.broken(str(error) or type(error).__name__)
    return offer


def known_leaves() -> dict[str, type[Leaf]]:
    """The leaves that task files may use, by their keys: the project's own, and of packages."""
    return Installed().classes


def _described(leaves: Mapping[str, type[Leaf]]) -> dict[str, LeafType]:
    """What their classes say; most tasks need no class to be checked."""
    from trees.language.leaf_classes import describe_leaves

    return describe_leaves(leaves)
