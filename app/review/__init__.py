"""Finished runs: find and list them, explain how they ended, read images from their recordings."""

from app.review.event_log import DamagedRunError
from app.review.explanation import explain
from app.review.finished import find_run, read_run, run_folders, runs_table
from app.review.recorded_images import recorded_depth

__all__ = [
    "DamagedRunError",
    "explain",
    "find_run",
    "read_run",
    "recorded_depth",
    "run_folders",
    "runs_table",
]
