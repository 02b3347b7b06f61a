"""`bench timing`."""

import pytest
from bench_call import report

QUICK = """\
task: quick
scene: single
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree: {navigate: {to: near}}
"""


def test_steps_ticks_and_the_steps_of_a_task_are_timed(tmp_path):
    task = tmp_path / "quick.yaml"
    task.write_text(QUICK)
    options = ("--robot", "omni", "--count", 10, "--task", task)
    kept = report(tmp_path, "timing", "step", "task", *options)
    assert kept["machine"]
    frankie, paper, run, ticks = kept["results"]
    assert (frankie["name"], paper["name"]) == ("omni: frankie", "omni: paper")
    assert run["name"] == "omni: quick, single, seed 0, step"
    assert run["steps"] > 50
    assert ticks["steps"] == run["steps"]
    assert run["median"] < ticks["median"]
    for timing in kept["results"]:
        assert timing["steps"] >= 10
        assert 0.0 < timing["median"] <= timing["p95"] <= timing["p99"] <= timing["worst"]
    assert 0.0 < run["cpu_median"] <= run["cpu_p95"]
    assert "CPU time: frankie / paper = " in kept["stdout"]


@pytest.mark.slow
def test_perception_is_timed(tmp_path):
    kept = report(tmp_path, "timing", "perception", "--count", 2)
    assert kept["results"][-1]["name"] == "perception: step"
