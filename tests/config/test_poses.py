"""Poses on the map and in odometry are two types for mypy."""

import subprocess
import sys
from pathlib import Path

import pytest

SNIPPET = """
from config.poses import MapFromOdometry, MapPose, OdometryPose
from controller import BaseGoal, KinematicState, MotionGoal, PoseGoal
from hw import RobotState

def step(state: KinematicState, goal: MotionGoal[MapPose]) -> None: ...

def right(state: RobotState, goal: PoseGoal[OdometryPose], mTo: MapFromOdometry) -> None:
    step(KinematicState(mTo * state.oTb, state.q), goal.on_map(mTo))
    back: OdometryPose = mTo.inverse() * (mTo * state.oTb)

def wrong(state: RobotState, goal: PoseGoal[OdometryPose], mTo: MapFromOdometry) -> None:
    here = KinematicState(state.oTb, state.q)
    step(here, goal)
    step(here, BaseGoal(target=state.oTb))
    there = mTo * here.mTb
    off = here.mTb.actInv(state.oTb)
"""


@pytest.mark.slow
def test_mypy_refuses_a_pose_of_the_other_frame(tmp_path):
    """Each line of `wrong` is told, and none of `right`."""
    (tmp_path / "snippet.py").write_text(SNIPPET)
    root = Path(__file__).parents[2]
    words = [sys.executable, "-m", "mypy", "--config-file", root / "pyproject.toml"]
    words += ["--cache-dir", tmp_path / "cache", tmp_path / "snippet.py"]
    told = subprocess.run(words, cwd=root, capture_output=True, text=True).stdout
    lines = SNIPPET.splitlines()
    wrong = range(lines.index(next(one for one in lines if "def wrong" in one)) + 2, len(lines) + 1)
    found = {int(line.split(":")[1]) for line in told.splitlines() if "snippet.py:" in line}
    assert found == set(wrong), told
