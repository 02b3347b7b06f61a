"""Planned motion, the baseline: the base drives to a stance, then the arm follows a trajectory.

Paths of the arm are planned by RRT-Connect of the Open Motion Planning Library (an extra).
"""

from controller.planning.planning_controller import PlanningController
from controller.planning.rrt import PlanningError, planning_library
from controller.planning.settings import PlanningSettings

__all__ = ["PlanningController", "PlanningError", "PlanningSettings", "planning_library"]
