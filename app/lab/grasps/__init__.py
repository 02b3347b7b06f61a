"""Training and evaluation of the grasp networks. Importing this does not import torch."""

from app.lab.grasps.choice import NetworkChoice
from app.lab.grasps.evaluate import (
    Evaluation,
    draw_failures,
    evaluate_grasps,
    evaluation_table,
)
from app.lab.grasps.fit import fit_outcomes
from app.lab.grasps.outcomes import collect_outcomes, read_outcomes
from app.lab.grasps.physical_evaluation import evaluate_by_physics
from app.lab.grasps.physical_table import physical_notes, physical_tables
from app.lab.grasps.probability import probability_table
from app.lab.grasps.recipe import read_recipe
from app.lab.grasps.scenes import ROBOT
from app.lab.grasps.show import show_grasps
from app.lab.grasps.step_time import (
    measure_perception,
    perception_json,
    perception_notes,
    perception_table,
)
from app.lab.grasps.train import train_weights
from app.lab.grasps.views import measure_views, views_notes, views_table

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
