"""Signals, sent to a real process: the first brings the robot to rest, the second ends it."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from waiting import until

TASK = """\
task: on
scene: single
poses: {away: {base: [30, 0], heading_deg: 0}}
tree: {drive: {to: away}}
"""


@pytest.fixture
def run(tmp_path):
    """A process whose robot moves, in real time; and the folder that it writes."""
    (tmp_path / "on.yaml").write_text(TASK)
    command = [sys.executable, "-m", "frankie_task_cli", "run", str(tmp_path / "on.yaml")]
    command += ["--view", "none", "--speed", "real", "--record", str(tmp_path / "runs")]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        until(lambda: speed_in(tmp_path / "runs") >= 0.2)
        (folder,) = (tmp_path / "runs").iterdir()
        yield process, folder
        process.kill()


def speed_in(runs: Path) -> float:
    """The last forward speed of the base that a run has written [m/s]; 0 before it writes."""
    for states in runs.glob("*/states.npy"):
        if states.stat().st_size and len(rows := np.load(states)):
            return rows[-1, 4]
    return 0.0


@pytest.mark.parametrize(
    "kind", [signal.SIGHUP, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_the_first_signal_brings_the_robot_to_rest_and_leaves_a_summary(run, kind):
    process, folder = run
    os.kill(process.pid, kind)
    _, err = process.communicate(timeout=60.0)
    assert (process.returncode, "Traceback" in err) == (130, False)
    assert json.loads((folder / "summary.json").read_text())["outcome"] == "interrupted"
    assert np.abs(np.load(folder / "states.npy")[-1, 4:7]).max() < 1e-2


@pytest.mark.slow
def test_the_second_signal_ends_the_process_at_once(run):
    process, folder = run
    os.kill(process.pid, signal.SIGSTOP)  # so that both arrive before the robot is at rest
    os.kill(process.pid, signal.SIGINT)
    os.kill(process.pid, signal.SIGTERM)
    os.kill(process.pid, signal.SIGCONT)
    process.communicate(timeout=60.0)
    assert process.returncode == 130
    assert not (folder / "summary.json").exists()
    assert np.load(folder / "commands.npy")[-1, 1] > 0.0  # nothing was waited for
