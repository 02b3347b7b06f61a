"""The bench of control steps times those of whole runs, too."""

import json

import pytest
from typer.testing import CliRunner

from app.commands import app


def test_every_step_of_a_run_is_timed(tmp_path):
    task, file = tmp_path / "quick.yaml", tmp_path / "step.json"
    task.write_text(
        "task: quick\nscene: single\n"
        "poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}\n"
        "tree: {navigate: {to: near}}\n"
    )
    arguments = ["bench", "step", "--robot", "omni", "--task", str(task), "--json", str(file)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert result.stdout.count(" µs: ") == 5
    (run,) = json.loads(file.read_text())["results"]
    assert run["timing"]["name"] == "omni: quick, single, seed 0"
    assert run["timing"]["steps"] > 50
    for slow in run["slowest"]:
        assert sum(slow["parts"].values()) == pytest.approx(slow["time"])
    assert run["slowest"][0]["time"] == run["timing"]["cpu_worst"]
