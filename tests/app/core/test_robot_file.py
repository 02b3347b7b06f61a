"""A task on a robot that is described by a person's own files."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import robots
from app.core import RunOptions, run_task
from app.live import View, ViewOptions

SHIPPED = Path(robots.__file__).parent
TASK = """\
task: fold
tree:
  sequence:
    - recover: {arm: ready}
    - arm_at: {posture: ready, within_deg: 1}
"""


@pytest.fixture
def task(tmp_path: Path) -> Path:
    path = tmp_path / "fold.yaml"
    path.write_text(TASK)
    return path


def options(tmp_path: Path, task: Path, robot: str) -> RunOptions:
    quiet = ViewOptions(view=View.NONE)
    return RunOptions(tree=task, robot=robot, scene="single", record=tmp_path / "runs", view=quiet)


def test_the_ready_posture_is_that_of_the_robot(tmp_path: Path, task: Path) -> None:
    shutil.copytree(SHIPPED, tmp_path / "mine")
    arm = tmp_path / "mine" / "parts" / "panda.yaml"
    usual, other = "[0.0, -0.3, 0.0, -2.2,", "[0.0, -0.5, 0.0, -2.4,"
    assert usual in arm.read_text()
    arm.write_text(arm.read_text().replace(usual, other))
    result = run_task(options(tmp_path, task, str(tmp_path / "mine" / "frankie.yaml")))
    assert result.outcome.end.exit_code == 0
    q = np.load(result.folder / "states.npy")[-1, 7:14]
    np.testing.assert_allclose(q[[1, 3]], [-0.5, -2.4], atol=0.02)
    assert result.summary.robot == "frankie"
