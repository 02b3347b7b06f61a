"""What a control period begins with: the robot's state, the goal, and the kinematics of now."""

from math import atan2
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from config.planar import Pose2D
from config.poses import MapPose
from controller.command import KinematicState, MotionGoal
from controller.model import Lag, RobotModel, manipulability
from controller.settings import ControllerSettings
from controller.stance.dexterity import dexterity
from controller.surroundings import Surroundings


class Linearisation(NamedTuple):
    """Kinematics and gradients at one posture."""

    bTe: SE3
    J: Array  # (6, n) Jacobian at the end effector in base axes
    manipulability: float  # of the arm
    gradient: Array  # (n,) Ĵ_m of the manipulability of the settings, times its gain (eq. 12)
    heading_error: float  # θ_ε: bearing of the end effector seen from the base [rad] (eq. 13)


def linearise(
    model: RobotModel,
    settings: ControllerSettings,
    q: Array,
    before: Linearisation | None = None,
) -> Linearisation:
    """Kinematics and gradients at joint positions q (j,) [rad].

    With a linearisation shortly before, manipulability and gradient are taken from it.
    """
    if before is not None:
        bTe, J = model.tool(q)
        m, gradient = before.manipulability, before.gradient
    else:
        bTe, J, screws, hessian = model.kinematics(q)
        n_base, dexterous = model.n_base, dexterity(model.description)
        gradient = np.zeros(model.n)
        of = dexterous.columns(n_base, model.n)
        m, gradient[of] = manipulability(screws[:, of], hessian[of][:, of])
        if settings.manipulability_of == "whole body":
            gradient = manipulability(screws, hessian)[1]
        elif settings.manipulability_of == "none":
            gradient = np.zeros(model.n)
        gradient *= settings.manipulability_gain / dexterous.usual
    x, y, _ = bTe.translation.tolist()
    return Linearisation(bTe, J, m, gradient, atan2(y, x))


class Situation(NamedTuple):
    """What terms and limits read in one period; n degrees of freedom, base first, then j joints."""

    model: RobotModel
    settings: ControllerSettings
    state: KinematicState  # base pose, and joint positions q (j,) [m, rad]
    base: Pose2D  # the base pose on the floor
    goal: MotionGoal[MapPose] | None
    applied: Array  # (n,) velocities of the last period [m/s, rad/s]
    kinematics: Linearisation
    surroundings: Surroundings
    lag: Lag  # the velocities that base and arm, which follow late, have now
