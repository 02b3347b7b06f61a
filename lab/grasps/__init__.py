"""Training and evaluation of the grasp networks. Importing this does not import torch."""

from lab.grasps.choice import NetworkChoice
from lab.grasps.depth_files import load_depth_file
from lab.grasps.evaluation import evaluate_grasps
from lab.grasps.grasp_outcomes import collect_outcomes, read_outcomes
from lab.grasps.hold_network import fit_hold_network, probability_table
from lab.grasps.results import evaluation_notes, evaluation_tables
from lab.grasps.scenes import ROBOT, noisy_frame
from lab.grasps.show import show_grasps
from lab.grasps.tilts import evaluate_tilts
from lab.grasps.train import TrainingRecipe, train_weights
