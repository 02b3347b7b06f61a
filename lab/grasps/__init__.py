"""Training and evaluation of the grasp networks. Importing this does not import torch."""

from lab.grasps.choice import NetworkChoice
from lab.grasps.evaluate import (
    Evaluation,
    draw_failures,
    evaluate_grasps,
    evaluation_table,
)
from lab.grasps.fit import fit_outcomes
from lab.grasps.outcomes import collect_outcomes, read_outcomes
from lab.grasps.physical_evaluation import evaluate_by_physics
from lab.grasps.physical_table import physical_notes, physical_tables
from lab.grasps.probability import probability_table
from lab.grasps.recipe import read_recipe
from lab.grasps.scenes import ROBOT
from lab.grasps.show import show_grasps
from lab.grasps.step_time import (
    measure_perception,
    perception_json,
    perception_notes,
    perception_table,
)
from lab.grasps.train import train_weights
from lab.grasps.views import measure_views, views_notes, views_table

__all__ = [
    "ROBOT",
    "Evaluation",
    "NetworkChoice",
    "collect_outcomes",
    "draw_failures",
    "evaluate_by_physics",
    "evaluate_grasps",
    "evaluation_table",
    "fit_outcomes",
    "measure_perception",
    "measure_views",
    "perception_json",
    "perception_notes",
    "perception_table",
    "physical_notes",
    "physical_tables",
    "probability_table",
    "read_outcomes",
    "read_recipe",
    "show_grasps",
    "train_weights",
    "views_notes",
    "views_table",
]
