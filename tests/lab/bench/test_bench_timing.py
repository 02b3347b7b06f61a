"""`bench step` and `bench perception`."""

from bench_call import report


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


def test_perception_is_timed(tmp_path):
    kept = report(tmp_path, "perception", "--count", 2)
    assert kept["results"][-1]["name"] == "step"
