"""How far the robot is from a goal of the hand or the arm."""

from __future__ import annotations

import numpy as np

from controller.command import KinematicState, PoseGoal, PostureGoal
from controller.holistic_qp import linearise
from controller.model import RobotModel
from controller.report import StepReport
from controller.servo import pose_error
from controller.settings import ControllerSettings


def left_to(
    goal: PoseGoal | PostureGoal,
    model: RobotModel,
    settings: ControllerSettings,
    state: KinematicState,
) -> StepReport:
    """A report with what is left to a goal, and with nothing of a plan."""
    linearisation = linearise(model, settings, state.q)
    if isinstance(goal, PostureGoal):
        position, angle = 0.0, float(np.abs(goal.q - state.q).max())
        arrived = angle <= goal.tolerance
    else:
        error = pose_error(state.wTb * linearisation.bTe, goal.wTe)
        position, angle = error.position, error.orientation
        arrived = position <= goal.position_tolerance and angle <= goal.orientation_tolerance
    return StepReport(
        arrived=arrived,
        position_error=position,
        orientation_error=angle,
        manipulability=linearisation.manipulability,
        heading_error=linearisation.heading_error,
        slack=0.0,
        solved=True,
        bTe=linearisation.bTe,
    )
