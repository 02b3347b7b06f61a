"""The bench of the main job prints and writes what the runs measured."""

import json
import subprocess
import sys
import time

import pytest
from typer.testing import CliRunner

from app.commands import app
from controller.planning import rrt

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
    options = ("--workers", 1, "--scene", "single", "--record", tmp_path / "r", "--json", figures)
    result = call(task, "--world", world, "--seeds", "2-3", *options)
    assert result.exit_code == 0, result.output
    report = json.loads(figures.read_text())
    assert [(run["seed"], run["world"]) for run in report["runs"]] == [(2, world), (3, world)]
    assert report["about"]["machine"]
    assert {run["placed"] for run in report["runs"]} == {0}
    assert result.stdout.count("0 of 1") == 3  # two runs, and both together


def test_the_base_keeps_the_limits_that_are_asked_for(tmp_path):
    back = tmp_path / "back.yaml"
    back.write_text(
        "task: back\nposes: {behind: {xyz: [-1.4, 0.0, 0.7], rpy_deg: [180, 0, 0]}}\n"
        "tree: {navigate: {to: behind}}\n"
    )
    figures, seconds = tmp_path / "figures.json", {}
    for reverse in (0.25, 1.0):
        speeds = ("--base-speed", 1.0, "--reverse-speed", reverse)
        options = ("--scene", "single", "--record", tmp_path / "r", "--json", figures)
        result = call(back, "--seeds", "0", "--workers", 1, *speeds, *options)
        assert result.exit_code == 0, result.output
        report = json.loads(figures.read_text())
        (row,), (run,) = report["results"], report["runs"]
        assert (row["base_speed"], row["reverse_speed"]) == (1.0, reverse)
        assert run["limit_violations"] == 0
        seconds[reverse] = run["duration_s"]
    assert seconds[1.0] < seconds[0.25] - 0.3


def test_the_limits_of_a_real_base_are_left_to_its_file():
    result = call("--robot", "emulated", "--reverse-speed", 1.0, "--seeds", "0", "--workers", 1)
    assert result.exit_code == 2
    assert "base_limits" in result.stderr


WANTED = {
    "objects",
    "placed",
    "attempts",
    "first_attempt_rate",
    "grasp_time_mean_s",
    "pick_place_time_mean_s",
    "stationary_fraction",
    "cumulative_jerk",
    "failures_by_cause",
}


def test_experiment_3_has_figures_of_an_object_that_was_really_carried(tmp_path):
    pytest.importorskip("matplotlib")
    figures, plots = tmp_path / "figures.json", tmp_path / "plots"
    options = ("--scene", "single", "--record", tmp_path / "r", "--json", figures, "--plot", plots)
    result = call("pick_one", "--seeds", "0", "--workers", 1, *options)
    assert result.exit_code == 0, result.output
    assert "15.6" in result.stdout  # the paper's figures stand beside
    (row,) = json.loads(figures.read_text())["results"]
    assert set(row) >= WANTED
    assert (row["motion"], row["objects"], row["placed"], row["attempts"]) == ("holistic", 1, 1, 1)
    assert row["first_attempt_rate"] == 1.0
    assert row["failures_by_cause"] == {}
    assert 0.5 < row["grasp_time_mean_s"] < row["reach_time_mean_s"]
    assert row["grasp_time_mean_s"] < row["pick_place_time_mean_s"] < 20.0
    assert 0.0 < row["stationary_fraction"] < 0.2
    assert 3.0 < row["distance_per_object_m"] < 9.0
    assert row["cumulative_jerk"] > 1.0
    assert sum(leaf["seconds"] for leaf in row["seconds_by_leaf"].values()) > 10.0
    assert len(list(plots.glob("*.png"))) == 3


def test_why_leaves_failed_is_counted_without_numbers(tmp_path):
    task, figures = tmp_path / "late.yaml", tmp_path / "figures.json"
    task.write_text(QUICK.replace("{to: near}", "{to: near, timeout_s: 0.2}, retry: 3"))
    options = ("--workers", 1, "--scene", "single", "--record", tmp_path, "--json", figures)
    call(task, "--seeds", "0", *options)
    (row,) = json.loads(figures.read_text())["results"]
    ((cause, count),) = row["failures_by_cause"].items()
    assert cause.startswith("navigate: not at near after # s")
    assert count == 3


@pytest.mark.slow
def test_both_kinds_of_motion_stand_beside_each_other(tmp_path):
    pytest.importorskip("ompl", reason="the extra `planning` is not installed")
    figures = tmp_path / "figures.json"
    options = ("--scene", "single", "--record", tmp_path / "r", "--json", figures, "--workers", 1)
    result = call("pick_one", "--seeds", "0", "--motion", "both", *options)
    assert result.exit_code == 0, result.output
    holistic, planning = json.loads(figures.read_text())["results"]
    assert (holistic["motion"], planning["motion"]) == ("holistic", "planning")
    assert holistic["placed"] == planning["placed"] == 1
    assert (holistic["plans"], planning["plans"] > 3) == (0, True)
    assert holistic["pick_place_time_mean_s"] < planning["pick_place_time_mean_s"]
    assert "planning / holistic" in result.stdout


def test_planning_without_its_extra_is_refused_before_anything_runs(tmp_path, monkeypatch):
    def find(name: str):
        raise ModuleNotFoundError(f"No module named {name!r}", name="ompl")

    monkeypatch.setattr(rrt, "import_module", find)
    result = call("--motion", "both", "--record", tmp_path / "r")
    assert result.exit_code == 2
    assert 'pip install "frankie-task[planning]"' in result.stderr
    assert not (tmp_path / "r").exists()


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
