"""`bench timing`."""

from importlib import import_module

import pytest
from bench_call import refused, report

from lab.bench import published

QUICK = """\
task: quick
scene: single
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree: {navigate: {to: near}}
"""


def test_steps_ticks_and_the_steps_of_a_task_are_timed(tmp_path):
    task = tmp_path / "quick.yaml"
    task.write_text(QUICK)
    options = ("--robot", "omni", "--count", 30, "--task", task)
    kept = report(tmp_path, "timing", "step", "task", "tree", *options)
    assert kept["machine"]
    frankie, paper, run, read, tick = kept["results"]
    assert (frankie["name"], paper["name"]) == ("omni: frankie", "omni: paper")
    assert run["name"] == "omni: quick, single, seed 0"
    assert run["steps"] > 50
    assert tick["median"] < read["median"]
    for timing in kept["results"]:
        assert timing["steps"] >= 30
        assert 0.0 < timing["median"] <= timing["p95"] <= timing["p99"] <= timing["worst"]
        assert 0.0 < timing["cpu_median"] <= timing["cpu_p95"]
    assert kept["stdout"].count(" µs: ") == 5  # the slowest steps
    assert "CPU time: frankie / paper = " in kept["stdout"]
    assert min(kept["omni parts"].values()) > 0.0
    assert kept["omni agreement"] is None


def test_the_toolbox_must_be_installed(monkeypatch):
    def find(name: str):
        if name.split(".")[0] == "roboticstoolbox":
            raise ModuleNotFoundError(f"No module named {name!r}", name="roboticstoolbox")
        return import_module(name)

    monkeypatch.setattr(published, "import_module", find)
    refused("pip install roboticstoolbox-python", "timing", "step", "--vs", "rtb", "--count", 10)


@pytest.mark.slow
def test_the_paper_preset_agrees_with_the_published_example(tmp_path):
    for package in ("roboticstoolbox", "qpsolvers", "quadprog"):
        pytest.importorskip(package)
    kept = report(tmp_path, "timing", "step", "--vs", "rtb", "--count", 1000)
    for robot in ("frankie", "omni"):
        assert kept[f"{robot} agreement"] < 1e-5


@pytest.mark.slow
def test_perception_and_starts_are_timed(tmp_path):
    kept = report(tmp_path, "timing", "perception", "start", "--task", "pick_one", "--count", 2)
    words, motion, check = kept["results"]
    assert 0.0 < words["median"] < motion["median"]
    assert 0.0 < check["median"] < motion["median"]
    assert kept["perception"]["times_ms"]


def test_a_task_that_cannot_start_is_one_line(tmp_path):
    task = tmp_path / "bad.yaml"
    task.write_text("task: bad\ntree: {nothing: {}}\n")
    refused("the run did not start: ", "timing", "start", "--task", task, "--count", 1)
