"""Drivers that packages offer: entry points `KIND.NAME` of the group `frankie_task.drivers`.

A driver is a function or class of its options, a pydantic model that derives from `DriverOptions`
and annotates its first parameter, and of a context. What is broken hinders only robots that use it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, ConfigDict, create_model

from config import PluginError, UserError, entries, imported, package_of, suggest
from config.reader import StrictModel

if TYPE_CHECKING:
    from importlib import metadata

GROUP = "frankie_task.drivers"
KINDS = ("arm", "base", "gripper", "camera", "laser")
SIMULATED = "simulated"  # the driver of parts that are not there
_IMPORT_TIMEOUT = 20.0  # of a package [s]


class DriverError(UserError):
    """There is no such driver, or it cannot be used."""


class DriverOptions(StrictModel):
    """Options of a driver, as they stand below `hardware` in a robot file."""

    driver: str = ""  # its name


@dataclass(frozen=True, kw_only=True)
class Driver:
    """What an entry point offers, imported."""

    kind: str
    name: str
    package: str  # with its version
    options: type[DriverOptions]
    make: Callable[[Any, Any], Any]
    """A part of the kind, not yet connected, from options and context."""


def find_driver(kind: str, name: str) -> Driver:
    """The driver that a robot file names; DriverError: in one line why it cannot be used."""
    found = [entry for entry in entries(GROUP) if entry.name == f"{kind}.{name}"]
    if not found:
        names = (one.partition(".")[2] for one in _names() if one.startswith(f"{kind}."))
        raise DriverError(f"no driver of kind {kind} is called `{name}`; {suggest(name, names)}")
    if len(found) > 1:
        packages = " and ".join(sorted(map(package_of, found)))
        raise DriverError(f"`{kind}.{name}` is offered by {packages}; uninstall one of them")
    driver = _imported(found[0])
    if isinstance(driver, DriverError):
        raise driver
    return driver


def has_driver(kind: str, name: str) -> bool:
    """Whether a package offers such a driver; nothing is imported."""
    return f"{kind}.{name}" in _names()


def installed_drivers() -> Iterator[Driver | DriverError]:
    """Every driver of the installed packages, or what is wrong with it, by kind and name."""
    for name in sorted(set(_names())):
        try:
            yield find_driver(*name.split(".", 1))
        except DriverError as error:
            yield error


def options_model(kind: str, name: str) -> type[DriverOptions]:
    """The options of a driver; where it cannot be used, a model that says so of any value."""
    try:
        return find_driver(kind, name).options
    except DriverError as error:
        text = str(error)

    def refuse(_: str) -> str:
        raise ValueError(text)

    refused: Any = Annotated[str, AfterValidator(refuse)]
    return create_model("Options", __base__=_AnyOptions, driver=(refused, ...))


class _AnyOptions(DriverOptions):
    model_config = ConfigDict(extra="ignore")


def _names() -> list[str]:
    return [entry.name for entry in entries(GROUP) if entry.name.partition(".")[0] in KINDS]


@cache
def _imported(entry: metadata.EntryPoint) -> Driver | DriverError:
    """What an entry point offers, or why it cannot be used; imported once in a process."""
    kind, _, name = entry.name.partition(".")
    try:
        make: Any = imported(entry, _IMPORT_TIMEOUT)
        options = _options(make)
        return Driver(kind=kind, name=name, package=package_of(entry), options=options, make=make)
    except Exception as error:  # of a package that anybody may have written
        return DriverError(_broken(entry, error))


def _broken(entry: metadata.EntryPoint, error: Exception) -> str:
    why = str(error) if isinstance(error, PluginError) else f"{type(error).__name__}: {error}"
    return (
        f"the driver `{entry.name}` of `{entry.value}` cannot be used: "
        f"{' '.join(why.split())[:200]}; fix or uninstall its package"
    )


def _options(make: object) -> type[DriverOptions]:
    """The model that annotates the first parameter of a driver."""
    if not callable(make):
        raise PluginError("it is no function or class")
    first, *_ = [*inspect.signature(make, eval_str=True).parameters.values(), None]
    options = None if first is None else first.annotation
    if not isinstance(options, type) or not issubclass(options, DriverOptions):
        raise PluginError("its first parameter is not annotated with a class of `DriverOptions`")
    return options
