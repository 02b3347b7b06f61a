"""The bench of the main job prints and writes what the runs measured."""

import json

from typer.testing import CliRunner

from app.commands import app

QUICK = """\
task: quick
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree: {navigate: {to: near}}
"""


def call(*arguments: object):
    return CliRunner().invoke(app, ["bench", "pick-place", *map(str, arguments)])


def test_one_row_a_seed_and_the_same_figures_as_json(tmp_path):
    task = tmp_path / "quick.yaml"
    task.write_text(QUICK)
    figures = tmp_path / "figures.json"
    result = call(
        task, "--scene", "single", "--seeds", "2-3", "--record", tmp_path / "r", "--json", figures
    )
    assert result.exit_code == 0, result.output
    report = json.loads(figures.read_text())
    assert [run["seed"] for run in report["runs"]] == [2, 3]
    assert report["about"]["machine"]
    assert {run["placed"] for run in report["runs"]} == {0}
    assert result.stdout.count("0 of 1") == 2


def test_a_wrong_range_of_seeds_is_refused_with_an_example(tmp_path):
    result = call("--seeds", "few", "--record", tmp_path)
    assert result.exit_code == 2
    assert "for example 0-4" in result.stderr
