"""Drivers that packages offer: entry points `KIND.NAME` of the group `frankie_task.drivers`.

A driver is a function or class of its options, a pydantic model that derives from `DriverOptions`
and annotates its first parameter, and of a context. What is broken hinders only robots that use it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, create_model

from config import DoorError, PluginError, entries, entry_of, package_of, used
from config.reader import StrictModel

GROUP = "frankie_task.drivers"
KINDS = ("arm", "base", "gripper", "camera", "laser")
SIMULATED = "simulated"  # the driver of parts that are not there


@dataclass(frozen=True, kw_only=True)
class SpeedRange:
    """Speeds at which a base can drive evenly [m/s, rad/s]."""

    forward: float = inf
    reverse: float = inf
    least_forward: float = 0.0
    least_reverse: float = 0.0
    least_turn: float = 0.0


class DriverOptions(StrictModel):
    """Options of a driver, as they stand below `hardware` in a robot file."""

    driver: str = ""  # its name

    @property
    def speeds(self) -> SpeedRange:
        """Those of a base, where its driver knows them."""
        return SpeedRange()


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
    """The driver that a robot file names; DoorError: in one line why it cannot be used."""
    entry = entry_of(GROUP, f"{kind}.{name}", "driver")

    def driver(make: Any) -> Driver:
        package, options = package_of(entry), _options(make)
        return Driver(kind=kind, name=name, package=package, options=options, make=make)

    return used(entry, "driver", driver)


def has_driver(kind: str, name: str) -> bool:
    """Whether a package offers such a driver; nothing is imported."""
    return f"{kind}.{name}" in _names()


def installed_drivers() -> Iterator[Driver | DoorError]:
    """Every driver of the installed packages, or what is wrong with it, by kind and name."""
    for name in sorted(set(_names())):
        try:
            yield find_driver(*name.split(".", 1))
        except DoorError as error:
            yield error


def options_model(kind: str, name: str) -> type[DriverOptions]:
    """The options of a driver; where it cannot be used, a model that says so of any value."""
    try:
        return find_driver(kind, name).options
    except DoorError as error:
        text = str(error)

    def refuse(_: str) -> str:
        raise ValueError(text)

    refused: Any = Annotated[str, AfterValidator(refuse)]
    return create_model("Options", __base__=_AnyOptions, driver=(refused, ...))


class _AnyOptions(DriverOptions):
    model_config = ConfigDict(extra="ignore")


def _names() -> list[str]:
    return [entry.name for entry in entries(GROUP) if entry.name.partition(".")[0] in KINDS]


def _options(make: object) -> type[DriverOptions]:
    """The model that annotates the first parameter of a driver."""
    if not callable(make):
        raise PluginError("it is no function or class")
    first, *_ = [*inspect.signature(make, eval_str=True).parameters.values(), None]
    options = None if first is None else first.annotation
    if not isinstance(options, type) or not issubclass(options, DriverOptions):
        raise PluginError("its first parameter is not annotated with a class of `DriverOptions`")
    return options
