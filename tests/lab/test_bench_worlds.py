"""The bench of worlds runs both, and asks the rules of the kinematic one about physical grasps."""

import json
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from app.commands import app
from lab.bench.worlds import Decision, WorldRun, worlds_notes

pytest.importorskip("mujoco", reason="needs the extra `physics`")

QUICK = """\
task: quick
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree: {navigate: {to: near}}
"""


def runs(tmp_path, *arguments: object) -> tuple[list[dict], str]:
    """What the bench writes, and what it prints."""
    figures = tmp_path / "figures.json"
    options = ("--scene", "single", "--workers", 1, "--record", tmp_path / "r", "--json", figures)
    call = ["bench", "worlds", *map(str, (*arguments, *options))]
    result = CliRunner().invoke(app, call)
    assert result.exit_code == 0, result.output
    return json.loads(figures.read_text())["runs"], result.stdout


def test_every_seed_runs_in_both_worlds(tmp_path):
    task = tmp_path / "quick.yaml"
    task.write_text(QUICK)
    made, told = runs(tmp_path, task, "--seeds", "2-3")
    summaries = [run["summary"] for run in made]
    assert [(one["seed"], one["world"]) for one in summaries] == [
        (2, "kinematic"),
        (2, "physics"),
        (3, "kinematic"),
        (3, "physics"),
    ]
    assert told.count("0 / 0 of 1") == 2
    assert "0 of 0 agree" in told


def test_disagreements_are_told_by_kind_and_one_by_one():
    def grasp(stamp: float, rule: str, ruled: str | None, held: str | None) -> Decision:
        touched = ruled or held
        return Decision(seed=4, stamp_s=stamp, rule=rule, ruled=ruled, touched=touched, held=held)

    decisions = (
        grasp(1.0, "held", "coffee mug 3", "coffee mug 3"),
        grasp(2.0, "only one pad touches", None, "coffee mug 12"),
        grasp(3.0, "held", "drill 1", None),
        grasp(4.0, "nothing between the fingers", None, None),
    )
    summary = SimpleNamespace(objects=2, placed=2, duration_s=10.0)
    notes = worlds_notes(
        [WorldRun(summary=summary), WorldRun(summary=summary, decisions=decisions)]
    )
    assert notes[1:] == [
        "grasps: 2 of 4 agree (50.0 %); false holds 25.0 %, false drops 25.0 %",
        "coffee mug: 1 of 2 agree",
        "drill: 0 of 1 agree",
        "seed 4, 2.0 s: by rule only one pad touches; physics holds coffee mug 12",
        "seed 4, 3.0 s: by rule held; physics does not hold drill 1",
    ]


@pytest.mark.slow
def test_a_grasp_is_decided_by_rule_and_by_physics(tmp_path):
    made, told = runs(tmp_path, "pick_one", "--seeds", "1")
    (decision,) = made[1]["decisions"]
    assert decision["rule"] == "held"
    assert decision["ruled"] == decision["held"] is not None
    assert "1 of 1 agree" in told
