"""The parts that one control step is made of, for whoever measures where its time goes."""

from __future__ import annotations

from typing import Any

from controller import controller, holistic
from controller.bounds import VelocityBounds
from controller.collision import Dampers, Proximity
from controller.guidance import Guide
from controller.model import RobotModel
from controller.qp import Solver

STEP_PARTS: dict[str, tuple[tuple[Any, str], ...]] = {
    "checks and bounds": ((controller, "check_inputs"), (VelocityBounds, "__call__")),
    "kinematics": ((RobotModel, "kinematics"),),
    "manipulability": ((holistic, "manipulability"),),
    "guidance": ((Guide, "bias"),),
    "distances": ((Proximity, "near"), (Dampers, "rows")),
    "build QP": ((controller, "build_qp"),),
    "solve": ((Solver, "solve"),),
}
"""The functions of every part, each as the module or class and the attribute it is called by."""
