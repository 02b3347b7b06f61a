"""Only one leaf moves the robot at a time: a task that has two at once is told so."""

import json

from command_line import call

TASK = """\
task: t
scene: single
poses:
  there: {xyz: [1.5, 0.3, 0.8], rpy_deg: [180, 0, 0]}
tree:
  parallel:
    - name: go there
      navigate: {to: there}
    - drive: {forward_m: 1.0}
"""


def test_leaves_that_move_and_do_not_say_so_end_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr("trees.language.lint._note_movers", lambda node, diagnostics: False)
    path = tmp_path / "t.yaml"
    path.write_text(TASK)
    code, out, _ = call("run", path, "--view", "none", "--record", tmp_path / "runs", "--json")
    assert code == 4
    summary = json.loads(out)
    assert "`go there` and `drive` both move the robot at the same time" in summary["reason"]
    assert summary["node"] == "drive"
