"""Runs a task: `run_task` starts a run, `Session` is its loop, `folder` names its files."""

from app.choices import ObstacleSource, RegistrationForm
from app.core.files.events import EVENTS
from app.core.files.folder import (
    COMMANDS,
    FRAMES,
    OPTIONS,
    PLACES,
    RECORDING,
    STATES,
    SUMMARY,
    TASK,
    begun,
    recorded_robot,
)
from app.core.files.whole import losses, whole_rows, whole_size
from app.core.launch import run_task
from app.core.measurements import TOO_SLOW
from app.core.outcome import End, Outcome
from app.core.replay import replay_run
from app.core.run import Instruments
from app.core.session import Session, Tick
from app.core.setup import Setup, open_setup, set_up
from app.core.snapshots import current_phases, recorded_scene
from app.core.summary import Result, Summary, how_it_ended, pick_place_times
from app.run_options import DEFAULT_SCENE, RunOptions
