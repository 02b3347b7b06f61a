"""Doors: entry points of installed packages, imported so that a broken one breaks nothing."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from config.diagnostics import UserError, quoted, suggest

if TYPE_CHECKING:
    from importlib import metadata

Made = TypeVar("Made")

_PATIENCE = 20.0  # for the import of a package [s]


class PluginError(Exception):
    """A package cannot be imported; the text says why."""


class DoorError(UserError):
    """No package offers what is asked for, or its package is broken."""


def find(group: str, name: str, noun: str) -> object:
    """What a package offers in a group by its name, imported; DoorError: in a line why not.

    `noun` says what it is, for people.
    """
    return used(entry_of(group, name, noun), noun, lambda offered: offered)


def entry_of(group: str, name: str, noun: str) -> metadata.EntryPoint:
    """The entry point of a name; DoorError: there is none, or more than one."""
    every = entries(group)
    found = [entry for entry in every if entry.name == name]
    if not found:
        known = {entry.name for entry in every}
        hint = suggest(name, known)
        also = "" if hint.startswith("known") else f" Installed: {quoted(sorted(known))}"
        raise DoorError(f"no {noun} is called `{name}`; {hint}{also}")
    if len({entry.value for entry in found}) > 1:
        packages = " and ".join(sorted(map(package_of, found)))
        raise DoorError(f"the {noun} `{name}` is offered by {packages}; uninstall one of them")
    return found[0]


def used(entry: metadata.EntryPoint, noun: str, made: Callable[[Any], Made]) -> Made:
    """What is made of what an entry point offers; DoorError: in a line why it cannot be used."""
    try:
        return made(imported(entry, _PATIENCE))
    except Exception as error:  # of a package that anybody may have written
        why = str(error) if isinstance(error, PluginError) else f"{type(error).__name__}: {error}"
        raise DoorError(
            f"the {noun} `{entry.name}` of {package_of(entry)} cannot be used: "
            f"{' '.join(why.split())[:200]}; fix or uninstall its package"
        ) from error


def package_of(entry: metadata.EntryPoint) -> str:
    """The package of an entry point, with its version."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else entry.value


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
        why = f"{type(found).__name__}: {found}"
        raise PluginError(f"{' '.join(why.split())[:200]} ({_place(found)})") from found
    return found


def _place(error: BaseException) -> str:
    """File and line where it was raised."""
    if isinstance(error, SyntaxError):
        return f"{error.filename}:{error.lineno}"
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{last.filename}:{last.lineno}"
