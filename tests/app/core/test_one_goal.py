"""Only one leaf moves the robot at a time: a task that has two at once is told so."""

import json

from typer.testing import CliRunner

from app.commands import app

TASK = """\
task: t
poses:
  there: {xyz: [1.5, 0.3, 0.8], rpy_deg: [180, 0, 0]}
tree:
  parallel:
    - name: go there
      navigate: {to: there}
    - drive: {forward_m: 1.0}
"""


def test_two_movers_side_by_side_end_the_run_and_both_are_named(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(TASK)
    command = ["run", str(path), "--view", "none", "--record", str(tmp_path / "runs"), "--json"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 4
    summary = json.loads(result.stdout)
    assert "`go there` and `drive` both move the robot at the same time" in summary["reason"]
    assert summary["node"] == "drive"
