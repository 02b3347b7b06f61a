"""Training and evaluation of the grasp networks. Importing this does not import torch."""

from app.lab.grasps.evaluate import (
    Evaluation,
    NetworkChoice,
    draw_failures,
    evaluate_grasps,
    evaluation_table,
)
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

__all__ = [
    "ROBOT",
    "Evaluation",
    "NetworkChoice",
    "draw_failures",
    "evaluate_grasps",
    "evaluation_table",
    "measure_perception",
    "perception_json",
    "perception_notes",
    "perception_table",
    "read_recipe",
    "show_grasps",
    "train_weights",
]
