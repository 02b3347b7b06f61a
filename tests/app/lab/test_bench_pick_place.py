"""The bench of the main job prints and writes what the runs measured."""

import json
import subprocess
import sys
import time

import pytest
from typer.testing import CliRunner

from app.commands import app

QUICK = """\
task: quick
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree: {navigate: {to: near}}
"""


def call(*arguments: object):
    return CliRunner().invoke(app, ["bench", "pick-place", *map(str, arguments)])


@pytest.mark.parametrize("world", ["kinematic", "physics"])
def test_one_row_a_seed_and_the_same_figures_as_json(tmp_path, world):
    if world == "physics":
        pytest.importorskip("mujoco", reason="needs the extra `physics`")
    task = tmp_path / "quick.yaml"
    task.write_text(QUICK)
    figures = tmp_path / "figures.json"
    options = ("--scene", "single", "--record", tmp_path / "r", "--json", figures)
    result = call(task, "--world", world, "--seeds", "2-3", *options)
    assert result.exit_code == 0, result.output
    report = json.loads(figures.read_text())
    assert [(run["seed"], run["world"]) for run in report["runs"]] == [(2, world), (3, world)]
    assert report["about"]["machine"]
    assert {run["placed"] for run in report["runs"]} == {0}
    assert result.stdout.count("0 of 1") == 2


def test_a_wrong_range_of_seeds_is_refused_with_an_example(tmp_path):
    result = call("--seeds", "few", "--record", tmp_path)
    assert result.exit_code == 2
    assert "for example 0-4" in result.stderr


@pytest.mark.slow
def test_runs_side_by_side_give_the_same_figures(tmp_path):
    task = tmp_path / "quick.yaml"
    task.write_text(QUICK)
    durations = []
    for workers in (1, 2):
        figures = tmp_path / f"{workers}.json"
        options = ("--scene", "single", "--record", tmp_path / "r", "--json", figures)
        result = call(task, "--seeds", "2-4", "--workers", workers, *options)
        assert result.exit_code == 0, result.output
        durations.append([run["duration_s"] for run in json.loads(figures.read_text())["runs"]])
    assert durations[0] == durations[1]


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_told_to_end_it_ends_the_run_and_begins_no_other(tmp_path, workers):
    task, runs = tmp_path / "long.yaml", tmp_path / "runs"
    task.write_text("task: long\ntree: {wait: {duration_s: 80000}}\n")
    command = ["bench", "pick-place", task, "--seeds", "0-9", "--scene", "single"]
    command += ["--workers", workers, "--record", runs]
    bench = subprocess.Popen(
        [sys.executable, "-m", "frankie_task_cli", *map(str, command)], stderr=subprocess.DEVNULL
    )
    try:
        while sum('"RUNNING"' in e.read_text() for e in runs.glob("*/events.jsonl")) < workers:
            assert bench.poll() is None
            time.sleep(0.05)
        bench.terminate()
        assert bench.wait(60.0) == 130
    finally:
        bench.kill()
    assert len(list(runs.glob("*/summary.json"))) == workers
    assert len(list(runs.iterdir())) == workers
