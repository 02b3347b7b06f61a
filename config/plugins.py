"""Entry points of installed packages, imported so that a broken one breaks nothing."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib import metadata


class PluginError(Exception):
    """A package cannot be imported; the text says why."""


def entries(group: str) -> list[metadata.EntryPoint]:
    """The entry points of a group, not yet imported."""
    from importlib import metadata  # slow, and most tasks use no plug-ins

    return list(metadata.entry_points(group=group))


def imported(entry: metadata.EntryPoint, patience: float) -> object:
    """The object of an entry point, imported on a thread within `patience` [s].

    Raises:
        PluginError: the import fails, exits, or does not end.
    """
    results: list[object] = []

    def load() -> None:
        try:
            results.append(entry.load())
        except BaseException as error:  # including `sys.exit`
            results.append(error)

    thread = threading.Thread(target=load, name=f"import of {entry.value}", daemon=True)
    try:
        thread.start()
    except RuntimeError as error:
        raise PluginError(f"{error}: end what else runs") from error
    thread.join(patience)
    if not results:
        raise PluginError(f"its import has not ended after {patience:g} s")
    (found,) = results
    if isinstance(found, KeyboardInterrupt):
        raise found
    if isinstance(found, BaseException):
        raise PluginError(f"{type(found).__name__}: {found}") from found
    return found
