"""The laboratory: benches, training and evaluation of grasp networks, and the tools they share."""

from app.lab.environment import machine
from app.lab.parts import Functions, PartTimer
from app.lab.progress_bar import progress
from app.lab.workers import ClusterError, run_all

__all__ = ["ClusterError", "Functions", "PartTimer", "machine", "progress", "run_all"]
