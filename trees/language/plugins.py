"""Leaves that installed packages offer, as entry points.

A package is code, and is trusted as such. But a broken one stops only the tasks that use it:
whatever it does while it is imported, its problem becomes a line of text.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from config import PluginError, imported

if TYPE_CHECKING:
    from importlib import metadata

    from behaviours import Leaf

ENTRY_POINTS = "frankie_task.behaviours"
"""Entry-point group in which other packages offer their leaves."""
PATIENCE = 20.0
"""How long the import of a package may take [s]."""


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
        leaf = imported(entry, PATIENCE)
    except PluginError as error:
        return offer.broken(str(error))
    if not isinstance(leaf, type) or not issubclass(leaf, Leaf):
        return offer.broken("it is no class that derives from Leaf or Condition")
    return Offer(name=entry.name, value=entry.value, leaf=leaf)
