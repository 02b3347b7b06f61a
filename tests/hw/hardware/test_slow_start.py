"""A robot that goes at a fifth of its speeds has five times as long for what it is to do."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from command_line import call
from emulated_robot import ROOT

from robots import at_pace, load_robot

TASK = """\
task: not_far
poses:
  near: {xyz: [1.3, 0.0, 0.7], rpy_deg: [180, 0, 0]}
tree:
  navigate: {to: near, timeout_s: 2}
"""


@pytest.mark.parametrize(
    ("knows_its_pace", "outcome"),
    [(True, "success"), pytest.param(False, "failure", marks=pytest.mark.slow)],
)
def test_timeouts_grow_as_a_robot_gets_slower(tmp_path, monkeypatch, knows_its_pace, outcome):
    def slow(_):
        robot = at_pace(load_robot(ROOT / "robots" / "emulated.yaml"), 0.2)
        return robot if knows_its_pace else replace(robot, pace=1.0)

    monkeypatch.setattr("hw.registry.load_robot", slow)
    task = tmp_path / "task.yaml"
    task.write_text(TASK)
    options = ["--scene", "single", "--view", "none", "--json", "--record", str(tmp_path)]
    told = json.loads(call("run", task, *options)[1])
    assert told["outcome"] == outcome, told["reason"]
    if knows_its_pace:
        assert told["duration_s"] > 4.0, "longer than the timeout at full speed"
