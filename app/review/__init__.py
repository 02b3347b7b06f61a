"""Finished runs: find, list and explain them, and what their recordings tell."""

from app.review.delays import Delay, NoMotionError, delays
from app.review.event_log import DamagedRunError
from app.review.explanation import explain
from app.review.finished import find_run, read_run, run_folders, runs_table
from app.review.recorded_images import recorded_depth

__all__ = [
    "DamagedRunError",
    "Delay",
    "NoMotionError",
    "delays",
    "explain",
    "find_run",
    "read_run",
    "recorded_depth",
    "run_folders",
    "runs_table",
]
