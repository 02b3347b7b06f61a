"""What `check --json` tells programs, and what a rule is about."""

from __future__ import annotations

import json

from command_line import call

DRAFT = """\
task: mistaken
poses:
  home: {base: [0, 0], heading_deg: 0}
  left_box: {base: [1, 1], heading_deg: 0}
  left_bar: {base: [1, 2], heading_deg: 0}
tree:
  sequence:
    - navigate: {to: "hoem", withn_m: 0.1}
    - selector: [{open_gripper: }]
    - drive: {to: left_ba}
    - wait: {duration_s: 100000}
    - drive: {to: left_bax}
"""


def test_findings_have_a_code_and_one_patch_for_all_that_is_certain_in_a_line(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(DRAFT)
    code, out, _ = call("check", path, "--json")
    found = json.loads(out)
    assert code == 2
    told = [(one["code"], one["line"], one["suggestion"]) for one in found[:4]]
    assert told == [
        ("R206", 8, "home"),
        ("R103", 8, "within_m"),
        ("R201", 9, "fallback"),
        ("R206", 10, "left_bar"),
    ]
    patches = [one["patch"] and one["patch"]["text"].strip() for one in found]
    assert patches[0] == patches[1] == '- navigate: {to: "home", within_m: 0.1}'
    assert patches[2:4] == ["- fallback: [{open_gripper: }]", "- drive: {to: left_bar}"]
    # Milliseconds; and a name that is as near to one as to another.
    assert patches[4] == "- wait: {duration_s: 100}"
    assert (found[5]["hint"][:24], patches[5]) == ("did you mean `left_box`?", None)


def test_a_rule_is_explained_by_its_code():
    code, out, _ = call("check", "--explain", "r201")
    assert code == 0
    assert out.startswith("R201: ")
    assert "{wiat: {duration_s: 1}}" in out
    code, _, err = call("check", "--explain", "R2011")
    assert code == 2
    assert "did you mean `R201`?" in err
