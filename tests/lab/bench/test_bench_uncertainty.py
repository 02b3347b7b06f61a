"""`bench uncertainty`: one row for each level, registration and scene."""

from bench_call import report

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
