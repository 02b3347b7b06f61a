"""The robot breaks while nobody reads the terminal, or the disk is full."""

import json
import resource
import subprocess
import sys

import numpy as np
import pytest

TASK = """\
task: drive_on
poses:
  away: {base: [60, 0], heading_deg: 0}
tree: {drive: {to: away}}
"""


def command(tmp_path, fault):
    (tmp_path / "task.yaml").write_text(TASK)
    run = [sys.executable, "-m", "frankie_task_cli", "run", str(tmp_path / "task.yaml")]
    run += ["--view", "none", "--json", "--fault", fault]
    return [*run, "--record", str(tmp_path / "runs")]


@pytest.mark.parametrize(
    ("fault", "trouble"),
    [
        ("reading breaks", "closed terminal"),
        pytest.param("sending fails", "closed stdout", marks=pytest.mark.slow),
    ],
)
def test_the_end_is_controlled_and_the_exit_code_tells_it(tmp_path, fault, trouble):
    """At 3 s the base drives at 1 m/s."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command(tmp_path, f"{fault}@3"), **pipes) as process:
        if trouble == "closed stdout":
            process.stdout.close()
        if trouble == "closed terminal":
            process.stdout.close()
            process.stderr.close()
        code = process.wait(timeout=120.0)
        err = "" if process.stderr.closed else process.stderr.read()
    assert code == 3
    assert "Traceback" not in err
    assert "Exception ignored" not in err


def nearly_full_disk() -> None:
    """As much as a run asks for before it begins, and no more."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))


def test_a_disk_that_fills_under_way_costs_the_ends_of_files_and_nothing_else(tmp_path):
    run = subprocess.run(
        command(tmp_path, "reading breaks@40"),
        preexec_fn=nearly_full_disk,
        capture_output=True,
        text=True,
        timeout=120.0,
    )
    assert run.returncode == 3
    assert "Traceback" not in run.stderr
    assert "ERROR" not in run.stderr
    told = "\n".join(json.loads(run.stdout)["warnings"])
    assert "recording.rrd: the recording ends early" in told
    assert "readings.npy ends early (File too large)" in told
    kept = np.load(next(tmp_path.glob("runs/*/readings.npy")))
    assert (kept["number"] == np.arange(len(kept))).all()
