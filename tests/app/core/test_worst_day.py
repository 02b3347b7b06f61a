"""The robot breaks while nobody reads the terminal."""

import subprocess
import sys

import pytest

TASK = """\
task: drive_on
poses:
  away: {base: [30, 0], heading_deg: 0}
tree: {drive: {to: away}}
"""


@pytest.mark.parametrize(
    ("fault", "trouble"),
    [
        ("reading breaks", "closed terminal"),
        ("sending fails", "closed stdout"),
        ("state frozen", "closed terminal"),
    ],
)
def test_the_end_is_controlled_and_the_exit_code_tells_it(tmp_path, fault, trouble):
    """At 3 s the base drives at 1 m/s."""
    (tmp_path / "task.yaml").write_text(TASK)
    command = [sys.executable, "-m", "frankie_task_cli", "run", str(tmp_path / "task.yaml")]
    command += ["--view", "none", "--json", "--fault", f"{fault}@3"]
    command += ["--record", str(tmp_path / "runs")]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as process:
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
