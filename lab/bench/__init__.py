"""Benches of the controller and of the whole robot, as commands that anybody can repeat.

The controller's motions are integrated without error and evaluated from their samples, not from its
own reports: joint and base limits, contacts, arrival, jerk. `run_pick_place` counts what the main
task achieves.
"""

from lab.bench.choosing import (
    Taking,
    choosing_json,
    choosing_notes,
    choosing_table,
    run_choosing,
)
from lab.bench.configuration import EXAMPLE, Configuration
from lab.bench.counting import counting_table, run_counting
from lab.bench.disturbance import NOISY, STARTS, Disturbance
from lab.bench.fault_matrix import QUICK, QUICK_PHASES
from lab.bench.fault_report import faults_json, faults_notes, faults_table
from lab.bench.faults import Cell, CellResult, cells, run_cells
from lab.bench.goals import PLACES, generate_goals, load_goals
from lab.bench.kinds import kinds_table, run_kinds
from lab.bench.moving import PATHS, Following, moving_table, run_following
from lab.bench.obstacle_plots import plot_worlds, trace_world
from lab.bench.obstacle_report import (
    ObstacleRow,
    obstacle_notes,
    obstacle_rows,
    obstacle_table,
)
from lab.bench.obstacle_worlds import FAMILIES
from lab.bench.obstacles import (
    CONTROLLERS,
    Setup,
    WorldTrial,
    make_world,
    run_worlds,
    world_names,
)
from lab.bench.on_the_move import (
    on_the_move_table,
    passing_figures,
    run_on_the_move,
    saving,
)
from lab.bench.pick_place import (
    PickPlaceRun,
    pick_place_json,
    pick_place_table,
    run_pick_place,
)
from lab.bench.pick_place_figures import (
    PickPlaceFigures,
    pick_place_figures,
    pick_place_notes,
    table_iv,
)
from lab.bench.pick_place_plots import plot_pick_place
from lab.bench.plots import make_plots, prepare_plots
from lab.bench.poses import POSES, PoseRun, pose_result, poses_tables, run_pose
from lab.bench.reach import (
    SWEEPS,
    Conditions,
    Reach,
    aggregate_trials,
    reach_notes,
    reach_table,
    run_trials,
)
from lab.bench.regenerate import Experiments, regenerate, regenerated_table
from lab.bench.signals import (
    KINDS,
    SPEEDS,
    SignalResult,
    run_signals,
    signal_cases,
    signals_json,
    signals_table,
)
from lab.bench.soak import Soak, run_soak, soak_json, soak_table
from lab.bench.start import start_table, time_start
from lab.bench.step import step_notes, step_table, time_steps
from lab.bench.step_near import time_near
from lab.bench.step_run import (
    RunSteps,
    run_steps_notes,
    run_steps_table,
    time_run,
)
from lab.bench.tree import time_tree, tree_table
from lab.bench.viewing import Watcher, measure_watching, watch_json, watch_table
from lab.bench.worlds import WorldRun, run_in_worlds, worlds_json, worlds_notes, worlds_table

__all__ = [
    "CONTROLLERS",
    "EXAMPLE",
    "FAMILIES",
    "KINDS",
    "NOISY",
    "PATHS",
    "PLACES",
    "POSES",
    "QUICK",
    "QUICK_PHASES",
    "SPEEDS",
    "STARTS",
    "SWEEPS",
    "Cell",
    "CellResult",
    "Conditions",
    "Configuration",
    "Disturbance",
    "Experiments",
    "Following",
    "ObstacleRow",
    "PickPlaceFigures",
    "PickPlaceRun",
    "PoseRun",
    "Reach",
    "RunSteps",
    "Setup",
    "SignalResult",
    "Soak",
    "Taking",
    "Watcher",
    "WorldRun",
    "WorldTrial",
    "aggregate_trials",
    "cells",
    "choosing_json",
    "choosing_notes",
    "choosing_table",
    "counting_table",
    "faults_json",
    "faults_notes",
    "faults_table",
    "generate_goals",
    "kinds_table",
    "load_goals",
    "make_plots",
    "make_world",
    "measure_watching",
    "moving_table",
    "obstacle_notes",
    "obstacle_rows",
    "obstacle_table",
    "on_the_move_table",
    "passing_figures",
    "pick_place_figures",
    "pick_place_json",
    "pick_place_notes",
    "pick_place_table",
    "plot_pick_place",
    "plot_worlds",
    "pose_result",
    "poses_tables",
    "prepare_plots",
    "reach_notes",
    "reach_table",
    "regenerate",
    "regenerated_table",
    "run_cells",
    "run_choosing",
    "run_counting",
    "run_following",
    "run_in_worlds",
    "run_kinds",
    "run_on_the_move",
    "run_pick_place",
    "run_pose",
    "run_signals",
    "run_soak",
    "run_steps_notes",
    "run_steps_table",
    "run_trials",
    "run_worlds",
    "saving",
    "signal_cases",
    "signals_json",
    "signals_table",
    "soak_json",
    "soak_table",
    "start_table",
    "step_notes",
    "step_table",
    "table_iv",
    "time_near",
    "time_run",
    "time_start",
    "time_steps",
    "time_tree",
    "trace_world",
    "tree_table",
    "watch_json",
    "watch_table",
    "world_names",
    "worlds_json",
    "worlds_notes",
    "worlds_table",
]
