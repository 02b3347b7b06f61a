"""Finished runs: list them, explain how they ended, open their recordings."""

from app.review.explanation import Explanation, NoEventsError, explain
from app.review.finished import (
    RunRecord,
    UnknownRunError,
    find_run,
    read_run,
    run_folders,
    runs_table,
)
from app.review.open_recording import open_in_viewer
from app.review.recorded_depth import NoDepthError, RecordedDepth, recorded_depth

__all__ = [
    "Explanation",
    "NoDepthError",
    "NoEventsError",
    "RecordedDepth",
    "RunRecord",
    "UnknownRunError",
    "explain",
    "find_run",
    "open_in_viewer",
    "read_run",
    "recorded_depth",
    "run_folders",
    "runs_table",
]
