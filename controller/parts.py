"""The parts that one control step is made of, for whoever measures where its time goes."""

from __future__ import annotations

from typing import Any

from controller import controller, holistic_qp
from controller.collision import DistanceConstraints, Proximity
from controller.guidance import Guidance
from controller.model import RobotModel
from controller.qp_solver import Solver
from controller.velocity_bounds import VelocityBounds

STEP_PARTS: dict[str, tuple[tuple[Any, str], ...]] = {
    "checks and bounds": ((controller, "check_inputs"), (VelocityBounds, "__call__")),
    "kinematics": ((RobotModel, "kinematics"),),
    "manipulability": ((holistic_qp, "manipulability"),),
    "guidance": ((Guidance, "bias"),),
    "distances": ((Proximity, "near"), (DistanceConstraints, "rows")),
    "build QP": ((controller, "build_qp"),),
    "solve": ((Solver, "solve"),),
}
"""The functions of every part, each as the module or class and the attribute it is called by."""
