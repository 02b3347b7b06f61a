"""`bench reach`, `poses`, `moving`, `step`, `perception` and `uncertainty`."""

import json
import sys

import pytest
from bench_call import call, refused, report


def test_reach_counts_the_results_of_all_goals(tmp_path):
    kept = report(tmp_path, "reach", "--count", 2, "--base-speed", 1.0, "--workers", 1)
    assert "Experiment 2" in kept["stdout"]
    assert kept["seed"] == 0
    assert kept["machine"]
    assert [(row["robot"], row["base_speed"]) for row in kept["results"]] == [
        ("frankie", 1.0),
        ("omni", 1.0),
    ]
    for row in kept["results"]:
        assert row["goals"] == 2
        assert row["failures"] == sum(row["failures_by_reason"].values()) == 0
        assert row["limit_violations"] == 0
        assert row["contact_samples"] == 0
        assert 0.5 < row["time_median_s"] <= row["time_p95_s"] <= row["time_max_s"] <= 20.0
        assert 0.0 < row["manipulability_mean"] < 0.2


def test_the_number_of_processes_does_not_change_the_figures(tmp_path):
    common = ("--robot", "omni", "--count", 7, "--base-speed", 1.5, "--limit", 1.0)
    one, two = (report(tmp_path, "reach", *common, "--workers", n)["results"] for n in (1, 2))
    assert one == two
    (row,) = one
    assert row["failures"] == sum(row["failures_by_reason"].values()) > 0
    assert len(row["failed_goals"]) == row["failures"]


def test_a_sweep_has_a_row_for_every_value_and_changes_the_outcome(tmp_path):
    options = ("--preset", "paper", "--robot", "frankie", "--count", 2, "--limit", 2)
    rows = report(tmp_path, "reach", *options, "--workers", 1, "--sweep", "heading")["results"]
    gains = [{"heading_gain": gain} for gain in (0.0, 0.1, 0.5, 1.0)]
    assert [row["changes"] for row in rows] == gains
    assert len({row["theta_eps_mean_deg"] for row in rows}) == 4


def test_bad_options_are_refused_in_one_line(tmp_path):
    for command in ("reach", "poses", "perception"):
        refused("cannot be written", command, "--json", tmp_path / "no" / "file")
    refused("stretched", "reach", "--starts", "streched", "--count", 1)
    refused("as 5-30", "reach", "--jitter-ms", "30-5", "--count", 1)
    refused("--pose e", "poses", "--pose", "e")


@pytest.mark.parametrize("starts", ["random", "limits", "singular", "stretched", "ready"])
def test_other_starts_and_uneven_periods_with_a_slow_reverse_speed(tmp_path, starts):
    options = ("--robot", "frankie", "--starts", starts)
    if starts == "ready":
        options = ("--robot", "omni", "--jitter-ms", "5-30", "--reverse-speed", 0.1)
    common = ("--base-speed", 1.0, "--count", 2, "--workers", 1)
    (row,) = report(tmp_path, "reach", *common, *options)["results"]
    assert (row["failures"], row["limit_violations"], row["contact_samples"]) == (0, 0, 0)
    if starts == "ready":
        assert row["conditions"]["jitter"] == [0.005, 0.03]
        assert row["reverse_speed"] == 0.1


def test_poses_reports_times_beside_those_of_the_paper(tmp_path):
    kept = report(tmp_path, "poses", "--robot", "frankie", "--pose", "a")
    assert "5.42" in kept["stdout"]
    (row,) = kept["results"]
    assert row["pose"] == "a"
    assert row["time_s"] < row["paper_time_s"]
    assert row["position_error_mm"] <= 10.0
    assert row["limit_violations"] == 0
    assert row["contact_samples"] == 0


@pytest.mark.slow
def test_moving_follows_every_path(tmp_path):
    for row in report(tmp_path, "moving", "--workers", 2)["results"]:
        assert row["error_max_mm"] < (10.0 if row["known"] else 40.0), row
        assert (row["limit_violations"], row["contact_samples"]) == (0, 0)


def test_a_cluster_needs_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    options = ("--count", 1, "--robot", "omni", "--cluster", "tcp://127.0.0.1:1")
    refused('pip install "frankie-task[cluster]"', "reach", *options)


def test_a_cluster_gives_the_same_figures_as_this_computer(tmp_path):
    distributed = pytest.importorskip("distributed")
    common = ("--robot", "omni", "--count", 7, "--base-speed", 1.5, "--limit", 1.0)
    here, there = tmp_path / "here.json", tmp_path / "there.json"
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(processes=False, **options) as cluster:
        address = cluster.scheduler_address
        assert call("reach", *common, "--cluster", address, "--json", there)[0] == 0
    assert call("reach", *common, "--workers", 1, "--json", here)[0] == 0
    assert json.loads(here.read_text()) == json.loads(there.read_text())


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


WAIT = """\
task: wait_a_little
tree:
  wait: {duration_s: 0.3}
"""


def test_one_row_for_each_level_registration_and_scene(tmp_path):
    task = tmp_path / "wait.yaml"
    task.write_text(WAIT)
    options = ("--localisation", "exact", "--localisation", "good", "--scene", "single")
    forms = ("--registration", "both", "--registration", "none", "--seeds", "0")
    run = ("--workers", 1, "--record", tmp_path / "runs")
    kept = report(tmp_path, "uncertainty", task, *options, *forms, *run)
    exact, both, none = kept["results"]
    names = [(one["level"], one["registration"]) for one in kept["results"]]
    assert names == [("exact", "-"), ("good", "both"), ("good", "none")]
    assert {one["runs"] for one in kept["results"]} == {1}
    assert [one["succeeded"] for one in kept["results"]] == [1, 1, 1]
    assert exact["position_error_m"] == exact["heading_error_rad"] == [0.0, 0.0]
    assert exact["nees"] is None
    assert 0.0 < both["position_error_m"][0] < none["position_error_m"][0] < 0.1
    assert 0.0 < both["nees"] < 3.0
    assert len(kept["runs"]) == 3
    assert "1/1" in kept["stdout"]
