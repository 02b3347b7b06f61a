"""The leaves that a task file may use: the project's own, and those of installed packages.

A broken package stops only the tasks that use it: whatever it does while it is imported, its
problem becomes a line of text. What the project's own classes say is kept, so that `check` need not
import those.
"""

from __future__ import annotations

import os
import pickle
import sys
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache, cached_property
from hashlib import sha256
from typing import TYPE_CHECKING

from config import entries, imported, user_cache
from trees.language.leaf_type import OWN_LEAVES, LeafType

if TYPE_CHECKING:
    from importlib import metadata

    from behaviours import Leaf

ENTRY_POINTS = "frankie_task.behaviours"  # in which other packages offer their leaves
IMPORT_TIMEOUT = 20.0  # of a package [s]


@cache
def offer_of(entry: metadata.EntryPoint) -> tuple[type[Leaf], LeafType] | str:
    """The leaf that an entry point offers and its description, or its problem in a line.

    It is imported once in a process.
    """
    from behaviours import Leaf

    try:
        leaf = imported(entry, IMPORT_TIMEOUT)
        if isinstance(leaf, type) and issubclass(leaf, Leaf):
            return leaf, _described({leaf.key: leaf})[leaf.key]
        why = "it is no class that derives from Leaf or Condition"
    except Exception as error:  # of a class that anybody may have written
        why = str(error) or type(error).__name__
    return _problem(entry, why)


def _problem(entry: metadata.EntryPoint, why: str) -> str:
    return (
        f"behaviour `{entry.name}` of `{entry.value}` cannot be used: "
        f"{' '.join(why.split())[:200]}; fix or uninstall its package"
    )


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
            offer = offer_of(entry)
            if not isinstance(offer, str) and (key := offer[0].key) in self.leaves:
                offer = _problem(entry, f"it takes the key `{key}`, which is taken")
            if isinstance(offer, str):
                self.problems[entry.name] = offer
            else:
                self._fetched[key], self.leaves[key] = offer
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


_ROOMS = ("behaviours", "config", "controller", "hw", "perception", "robots", "trees")
_BEGUN = time.time_ns()  # a module that has changed since may be loaded as it was before


def declared_leaves() -> dict[str, LeafType]:
    """The project's own leaves, by their keys, `set` and `add` among them.

    To import their classes takes as long as to check a task. So what they say is kept in the user's
    cache until a file changes that was imported with them.
    """
    kept = user_cache() / f"leaves-{sha256(__file__.encode()).hexdigest()[:12]}.pickle"
    with suppress(Exception):  # none is kept yet, or by another version
        leaves: dict[str, LeafType]
        stamps, leaves = pickle.loads(kept.read_bytes())
        if stamps == _stamps(stamps):
            return dict(OWN_LEAVES) | leaves
    from behaviours import LEAVES

    leaves = {key: _described({key: leaf})[key].deferred() for key, leaf in LEAVES.items()}
    ours = (one for name, one in [*sys.modules.items()] if name.partition(".")[0] in _ROOMS)
    stamps = _stamps(str(module.__file__) for module in ours)
    draft = kept.with_suffix(f".{os.getpid()}")
    with suppress(OSError):  # they are described again the next time
        if max(stamps.values()) < _BEGUN:
            kept.parent.mkdir(parents=True, exist_ok=True)
            draft.write_bytes(pickle.dumps((stamps, leaves)))
            draft.replace(kept)
    return dict(OWN_LEAVES) | leaves


def _stamps(files: Iterable[str]) -> dict[str, int]:
    """When each file was changed last [ns]."""
    return {file: os.stat(file).st_mtime_ns for file in files}
