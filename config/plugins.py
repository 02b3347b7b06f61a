"""What installed packages offer as entry points, imported so that a broken one breaks nothing."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib import metadata


class PluginError(Exception):
    """A package cannot be imported; the text says why."""


def entries(group: str) -> list[metadata.EntryPoint]:
    """What installed packages offer in a group, not yet imported."""
    from importlib import metadata  # most tasks name nothing that packages offer

    return list(metadata.entry_points(group=group))


def imported(entry: metadata.EntryPoint, patience: float) -> object:
    """What an entry point names, imported on a thread that need not end.

    Args:
        entry: of a package that anybody may have written.
        patience: how long the import may take [s].

    Raises:
        PluginError: it fails, ends the program, or does not end.
    """
    results: list[object] = []

    def load() -> None:
        try:
            results.append(entry.load())
        except BaseException as error:  # a package that calls `sys.exit` ends nothing but itself
            results.append(error)

    thread = threading.Thread(target=load, name=f"import of {entry.value}", daemon=True)
    thread.start()
    thread.join(patience)
    if not results:
        raise PluginError(f"its import has not ended after {patience:g} s")
    (found,) = results
    if isinstance(found, KeyboardInterrupt):
        raise found
    if isinstance(found, BaseException):
        raise PluginError(f"{type(found).__name__}: {found}") from found
    return found
