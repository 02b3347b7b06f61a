"""Run a module of a driver alone: `python light.py MODULE ARGUMENTS`.

A process with a loop at 1 kHz does not import the rest of the project, which takes a second, nor
the web clients in the vendor's package.
"""

import importlib
import sys
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType


def light_package(name: str, places: Iterable[str]) -> None:
    """Register a package by its folders, without running its `__init__.py`."""
    package = ModuleType(name)
    package.__path__ = list(places)
    sys.modules[name] = package


if __name__ == "__main__":
    home = Path(__file__).resolve().parents[2]
    module = sys.argv.pop(1)
    room, _, _ = module.rpartition(".")
    for package in {"hw", room.partition(".")[0], room}:
        light_package(package, [str(home.joinpath(*package.split(".")))])
    importlib.import_module(module).main()
