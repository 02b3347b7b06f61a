"""Planned motion, the baseline: the base drives to a stance, then the arm follows a trajectory.

Paths of the arm are planned by RRT-Connect of the Open Motion Planning Library (an extra).
"""

from lab.bench.planning.arm_planner import PlanningSettings
from lab.bench.planning.planning_controller import PlanningController
from lab.bench.planning.rrt import planning_library
