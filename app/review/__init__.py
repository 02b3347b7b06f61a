"""Finished runs: find, list and explain them, and read their recordings."""

from app.review.event_log import (
    DamagedRunError,
    FaultEvent,
    Log,
    NodeEvent,
    NowEvent,
    PauseEvent,
    ResumeEvent,
    read_log,
    recorded_time,
)
from app.review.explanation import Explanation, explain
from app.review.finished import find_run, read_motion, read_run, run_folders, runs_table
from app.review.recorded_images import NoDepthError, chunks, depth_images, recorded_depth
from app.review.timeline import Timeline, retold, timeline, tree_of
