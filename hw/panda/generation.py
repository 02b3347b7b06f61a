"""What is true of one generation of Franka arms, and what an arm of another would bring.

The seam for an FR3 is here: a `Generation` of its own with other limits and another interface
version, and a library that speaks it. Everything else of the driver asks the generation.
"""

from __future__ import annotations

import importlib
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from types import ModuleType

from hw.processes.light import light_package

Joints = tuple[float, ...]
"""One value for each of the seven joints."""


@dataclass(frozen=True, kw_only=True)
class JointLimits:
    """What the arm accepts of a commanded motion; beyond, it stops with a reflex."""

    q_min: Joints
    """[rad]"""
    q_max: Joints
    """[rad]"""
    qd: Joints
    """[rad/s]"""
    qdd: Joints
    """[rad/s^2]"""
    qddd: Joints
    """[rad/s^3]"""


@dataclass(frozen=True, kw_only=True)
class Generation:
    """One generation of the arm."""

    name: str
    interface: int
    """The version of the research interface that it speaks."""
    limits: JointLimits
    library: tuple[str, str]
    """Package and extension module that speak it."""


PANDA = Generation(
    name="Panda",
    interface=5,
    limits=JointLimits(
        q_min=(-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
        q_max=(2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
        qd=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        qdd=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        qddd=(7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0),
    ),
    library=("panda_py", "libfranka"),
)


def missing(generation: Generation = PANDA) -> str:
    """What to tell a person if the library is not there; empty if it is."""
    if find_spec(generation.library[0]) is not None:
        return ""
    return (
        f"the driver of the {generation.name} is not installed: "
        'pip install "frankie-task[hardware]"'
    )


def load_library(generation: Generation = PANDA) -> ModuleType:
    """The vendor's library, without running the front of the package that carries it.

    Raises:
        ImportError: it is not installed.
    """
    package, module = generation.library
    if package not in sys.modules:
        spec = importlib.util.find_spec(package)
        if spec is None or spec.submodule_search_locations is None:
            raise ImportError(missing(generation))
        light_package(package, spec.submodule_search_locations)
    return importlib.import_module(f"{package}.{module}")
