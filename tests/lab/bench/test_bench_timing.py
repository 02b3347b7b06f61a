"""`bench step` and `bench timing`."""

import pytest
from bench_call import report

QUICK = """\
task: quick
scene: single
poses: {near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}}
tree: {navigate: {to: near}}
"""


def test_steps_are_timed_beside_those_of_a_peer_that_reaches_the_same_goals(tmp_path):
    ours, pink = report(tmp_path, "step", "--robot", "omni", "--vs", "pink", "--count", 10)[
        "results"
    ]
    assert (ours["controller"], pink["controller"]) == ("frankie", "pink")
    assert min(ours["steps"], pink["steps"]) >= 10
    assert pink["ratio"] == pink["median"] / ours["median"]
    assert pink["infeasible"] == 0
    (reach,) = report(tmp_path, "reach", "--robot", "omni", "--preset", "pink", "--count", 1)[
        "results"
    ]
    assert reach["failures"] == 0
    assert reach["limit_violations"] > 0


def test_ticks_and_the_steps_of_a_task_are_timed(tmp_path):
    task = tmp_path / "quick.yaml"
    task.write_text(QUICK)
    kept = report(tmp_path, "timing", "task", "--robot", "omni", "--task", task)
    assert kept["machine"]
    run, ticks = kept["results"]
    assert run["name"] == "omni: quick, single, seed 0, step"
    assert run["steps"] > 50
    assert ticks["steps"] == run["steps"]
    assert run["median"] < ticks["median"]
    for timing in kept["results"]:
        assert timing["steps"] >= 10
        assert 0.0 < timing["median"] <= timing["p95"] <= timing["p99"] <= timing["worst"]
    assert 0.0 < run["cpu_median"] <= run["cpu_p95"]


@pytest.mark.slow
def test_perception_is_timed(tmp_path):
    kept = report(tmp_path, "timing", "perception", "--count", 2)
    assert kept["results"][-1]["name"] == "perception: step"
