"""Chains of goals, jitter and goals that move, as a person calls these benches."""

import json

import pytest
from test_bench_commands import call, refused


def test_reach_goes_on_from_goal_to_goal_with_periods_that_last_too_long(tmp_path):
    file = tmp_path / "reach.json"
    common = ("--robot", "frankie", "--base-speed", 1.0, "--count", 6, "--workers", 1)
    code, _, _ = call("reach", *common, "--chain", 3, "--jitter-ms", "5-30", "--json", file)
    assert code == 0
    (row,) = json.loads(file.read_text())["results"]
    assert (row["goals"], row["chain"], row["jitter_s"]) == (6, 3, [0.005, 0.03])
    assert (row["failures"], row["limit_violations"], row["contact_samples"]) == (0, 0, 0)


def test_a_jitter_that_is_no_interval_is_refused():
    refused("as 5-30", "reach", "--jitter-ms", "30-5", "--count", 1)


@pytest.mark.slow
def test_moving_follows_every_path(tmp_path):
    file = tmp_path / "moving.json"
    assert call("moving", "--workers", 2, "--json", file)[0] == 0
    for row in json.loads(file.read_text())["results"]:
        assert row["error_max_mm"] < (10.0 if row["known"] else 40.0), row
        assert row["tilt_max_deg"] < 2.0
        assert (row["limit_violations"], row["contact_samples"]) == (0, 0)
