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
    hardware = Path(__file__).resolve().parents[1]
    module = sys.argv.pop(1)
    room = module.split(".")[1]
    light_package("hw", [str(hardware)])
    light_package(f"hw.{room}", [str(hardware / room)])
    importlib.import_module(module).main()
