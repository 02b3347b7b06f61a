"""Limits of the Panda, and the vendor's library that speaks its interface."""

import importlib
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from types import ModuleType

from drivers.processes.light import light_package

Joints = tuple[float, ...]  # one value for each of the seven joints


@dataclass(frozen=True, kw_only=True)
class JointLimits:
    """Limits of a commanded motion [rad, rad/s, rad/s^2, rad/s^3]; beyond, the arm stops."""

    q_min: Joints
    q_max: Joints
    qd: Joints
    qdd: Joints
    qddd: Joints


INTERFACE_VERSION = 5  # of the Franka research interface
LIMITS = JointLimits(
    q_min=(-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973),
    q_max=(2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973),
    qd=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
    qdd=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
    qddd=(7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0),
)
_PACKAGE = "panda_py"


def missing() -> str:
    """Why the library cannot be loaded; empty if it can."""
    from config import extra  # not for the processes of the driver

    if find_spec(_PACKAGE) is not None:
        return ""
    return f"the driver of the Panda is not installed: {extra('hardware')}"


def load_library() -> ModuleType:
    """The extension module `libfranka`, without importing the package that contains it."""
    if _PACKAGE not in sys.modules:
        spec = find_spec(_PACKAGE)
        if spec is None or spec.submodule_search_locations is None:
            raise ImportError(missing())
        light_package(_PACKAGE, spec.submodule_search_locations)
    return importlib.import_module(f"{_PACKAGE}.libfranka")
