"""The shipped task that does not wait for its hand."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands import app
from trees import shipped


def run(record: Path, task: object) -> dict:
    command = ["run", str(task), "--record", str(record), "--json"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def one_object(folder: Path, slot: int, waits: bool) -> Path:
    """The task for one of its objects; `waits` leaves out every `next_goal`."""
    source = shipped("long_table")
    part = source.with_name("parts") / "carry_to.yaml"
    text = part.read_text()
    assert text.count("next_goal: $at_target") == 2
    (folder / "parts").mkdir(parents=True)
    kept = re.sub(r", next_goal: \$at_target", "", text) if waits else text
    (folder / "parts" / part.name).write_text(kept)
    lines = source.read_text().splitlines()
    task = folder / "one.yaml"
    task.write_text(
        "\n".join(x for x in lines if "subtree:" not in x or f"source: slot_{slot}," in x)
    )
    return task


@pytest.mark.slow
def test_the_base_that_sets_out_with_the_grasp_is_faster(tmp_path):
    moving = run(tmp_path / "a", one_object(tmp_path / "moving", 10, waits=False))
    waiting = run(tmp_path / "b", one_object(tmp_path / "waiting", 10, waits=True))
    for summary in (moving, waiting):
        assert summary["scene"] == "long_table"
        assert (summary["placed"], summary["attempts"]) == (1, 1)
        assert summary["limit_violations"] == summary["contacts"] == 0
    assert moving["duration_s"] < waiting["duration_s"] - 0.2


@pytest.mark.slow
def test_all_twelve_are_carried_in_one_run(tmp_path):
    summary = run(tmp_path, "long_table")
    assert (summary["placed"], summary["objects"]) == (12, 12)
    assert summary["limit_violations"] == 0
