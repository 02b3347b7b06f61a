"""Run a module of this room alone: `python light.py MODULE ARGUMENTS`.

A process with a loop at 1 kHz has no use for the rest of the project, which takes a second to
import, nor for the web clients that the front of the vendor's package brings with it.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType


def light_package(name: str, places: Iterable[str]) -> None:
    """Make a package known by its places, without running its front."""
    package = ModuleType(name)
    package.__path__ = list(places)
    sys.modules[name] = package


if __name__ == "__main__":
    room = Path(__file__).resolve().parent
    light_package("hw", [str(room.parent)])
    light_package("hw.panda", [str(room)])
    importlib.import_module(sys.argv.pop(1)).main()
