import json

import pytest
from typer.testing import CliRunner

from app.commands import app


@pytest.mark.slow
def test_bench_start_measures_words_before_motion(tmp_path):
    figures = tmp_path / "figures.json"
    result = CliRunner().invoke(
        app, ["bench", "start", "pick_one", "--runs", "1", "--json", str(figures)]
    )
    assert result.exit_code == 0, result.output
    [start] = json.loads(figures.read_text())["results"]
    assert 0.0 < start["words_s"] < start["motion_s"]
    assert 0.0 < start["check_s"] < start["motion_s"]
    assert "first motion" in result.output


def test_a_task_that_cannot_start_is_one_line(tmp_path):
    task = tmp_path / "bad.yaml"
    task.write_text("task: bad\ntree: {nothing: {}}\n")
    result = CliRunner().invoke(app, ["bench", "start", str(task), "--runs", "1"])
    assert result.exit_code == 2
    assert result.output.startswith("the run did not start: ")
