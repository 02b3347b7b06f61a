"""`bench pick-place`: Experiment 3."""

import subprocess
import sys
import time

import pytest
from bench_call import call, refused, report

from lab.bench.planning import rrt

QUICK = """\
task: quick
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree: {navigate: {to: near}}
"""
BACK = QUICK.replace("[0.9, 0.1, 0.7]", "[-1.4, 0.0, 0.7]")


def measured(tmp_path, task: str, *options: object) -> dict:
    """The report on a task, shipped or as text, in the scene `single`."""
    if "\n" in task:
        (tmp_path / "quick.yaml").write_text(task)
        task = str(tmp_path / "quick.yaml")
    where = ("--scene", "single", "--record", tmp_path / "runs")
    return report(tmp_path, "pick-place", task, *where, *options)


def test_the_base_keeps_the_given_limits(tmp_path):
    speeds = ("--base-speed", 1.0, "--reverse-speed", 0.5)
    kept = measured(tmp_path, BACK, "--seeds", "0", "--workers", 1, *speeds)
    (row,), (run,) = kept["results"], kept["runs"]
    assert (row["base_speed"], row["reverse_speed"]) == (1.0, 0.5)
    assert run["limit_violations"] == 0


def test_bad_options_are_refused_before_anything_runs(tmp_path, monkeypatch):
    def find(name: str):
        raise ModuleNotFoundError(f"No module named {name!r}", name="ompl")

    common = ("pick-place", "--record", tmp_path / "runs", "--workers", 1)
    code, _, err = call(*common, "--robot", "emulated", "--reverse-speed", 1.0, "--seeds", "0")
    assert code == 2
    assert "base_limits" in err  # the limits of a real base belong in its file
    refused("for example 0-4", *common, "--seeds", "few")
    monkeypatch.setattr(rrt, "import_module", find)
    refused('pip install "frankie-task[planning]"', *common, "--motion", "both")
    assert not (tmp_path / "runs").exists()


def test_causes_of_failures_are_counted_without_numbers(tmp_path):
    late = QUICK.replace("{to: near}", "{to: near, timeout_s: 0.2}, retry: 3")
    (row,) = measured(tmp_path, late, "--seeds", "0", "--workers", 1)["results"]
    ((cause, count),) = row["failures_by_cause"].items()
    assert cause.startswith("navigate: not at near after # s")
    assert count == 3


@pytest.mark.slow
def test_both_motion_forms_beside_each_other(tmp_path):
    pytest.importorskip("ompl", reason="the extra `planning` is not installed")
    kept = measured(tmp_path, "pick_one", "--seeds", "0", "--motion", "both", "--workers", 1)
    holistic, planning = kept["results"]
    assert (holistic["motion"], planning["motion"]) == ("holistic", "planning")
    for row in (holistic, planning):
        assert (row["objects"], row["placed"], row["attempts"]) == (1, 1, 1)
        assert row["first_attempt_rate"] == 1.0
        assert row["failures_by_cause"] == {}
        assert 0.5 < row["grasp_time_mean_s"] < row["pick_place_time_mean_s"] < 30.0
        assert 3.0 < row["distance_per_object_m"] < 9.0
    assert holistic["pick_place_time_mean_s"] < planning["pick_place_time_mean_s"]
    assert "planning / holistic" in kept["stdout"]
    assert "15.6" in kept["stdout"]  # the paper's figures


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_terminated_bench_ends_its_runs_and_begins_no_other(tmp_path, workers):
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
