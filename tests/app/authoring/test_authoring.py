"""The commands for whoever writes tasks, as a person meets them."""

from __future__ import annotations

import json
from xml.etree import ElementTree

import pytest
from command_line import call

from behaviours import LEAVES
from trees.language import COMPOSITES, MODIFIERS


def test_nodes_tells_all_words_or_all_about_one():
    code, out, _ = call("nodes")
    assert code == 0
    first = {line.split()[0].rstrip(":;") for line in out.splitlines()}
    assert {*LEAVES, *COMPOSITES, *MODIFIERS, "name", "subtree", "set"} <= first
    (grasp,) = [line for line in out.splitlines() if line.startswith("grasp: ")]
    assert "within, [choose]" in grasp
    _, out, _ = call("nodes", "grasp")
    (line,) = [line for line in out.splitlines() if line.startswith("  lock_distance_m")]
    for part in ("a number", "[m]", "(0.25)", "nearer than this to the camera"):
        assert part in line
    for word in ("wait", "parallel", "retry", "name", "subtree", "set"):
        code, out, _ = call("nodes", word)
        assert (code, out.startswith(word)) == (0, True)
    assert "  count: a key that takes a whole number" in call("nodes", "scan_for_objects")[1]
    code, out, err = call("nodes", "graps")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "did you mean `grasp`?" in err


def test_draw_prints_or_writes_a_picture(tmp_path):
    code, out, _ = call("draw", "pick_one")
    assert code == 0
    assert "pick (sequence)  [retry: $attempts]" in out
    picture = tmp_path / "tree.txt"
    code, told, _ = call("draw", "pick_one", "--output", picture)
    assert (code, told) == (0, f"{picture}: written\n")
    assert picture.read_text() == out


@pytest.mark.parametrize("command", ["draw", "export"])
def test_a_task_with_mistakes_is_located(tmp_path, command):
    path = tmp_path / "broken.yaml"
    path.write_text("task: broken\ntree:\n  sequence:\n    - open_griper\n")
    code, out, err = call(command, path)
    assert (code, out) == (2, "")
    assert err.startswith(f"{path}:4:7: ")
    assert "did you mean `open_gripper`" in err


def test_a_new_task_is_sound_complete_for_the_editor_and_runs(tmp_path):
    code, out, _ = call("new", "tidy_up", "--folder", tmp_path)
    task = tmp_path / "tidy_up.yaml"
    assert code == 0
    assert str(task) in out
    assert call("check", task) == (0, f"{task}: good\n", "")
    assert task.read_text().startswith("# yaml-language-server: $schema=frankie-task.schema.json\n")
    schema = (tmp_path / "frankie-task.schema.json").read_text()
    assert "grasp" in json.loads(schema)["definitions"]["node"]["properties"]
    assert call("schema") == (0, schema, "")
    code, out, _ = call("dry", task)
    assert (code, "tidy_up, dry: success" in out) == (0, True)


def test_new_writes_over_nothing_and_nowhere_else(tmp_path):
    assert call("new", "../up", "--folder", tmp_path)[0] == 2
    (tmp_path / "mine.yaml").write_text("precious")
    (tmp_path / "frankie-task.schema.json").write_text("mine too")
    code, _, err = call("new", "mine", "--folder", tmp_path)
    assert code == 2
    assert "already exists" in err
    assert (tmp_path / "mine.yaml").read_text() == "precious"
    assert call("new", "other", "--folder", tmp_path)[0] == 0
    assert (tmp_path / "frankie-task.schema.json").read_text() == "mine too"


def test_a_task_becomes_xml_for_bt_cpp():
    code, out, _ = call("export", "pick_one")
    assert (code, ElementTree.fromstring(out).get("BTCPP_format")) == (0, "4")


def test_reach_shows_that_a_tilted_hand_gets_higher_and_farther():
    code, out, _ = call("reach", "--height", 1.2)
    height, *far = out.splitlines()[1].split()
    assert (code, height) == (0, "1.20")
    assert [float(metres) for metres in far] == sorted(map(float, far))
    assert 0.3 < float(far[0]) < 0.55
    assert 0.9 < float(far[-1]) < 1.0
    assert call("reach", "--height", 1.35)[1].splitlines()[1].split()[1] == "-"


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


def test_an_old_word_becomes_the_new_one_where_it_asks_conditions_alone(tmp_path):
    path = tmp_path / "t.yaml"
    kept = "{reactive_sequence: [arm_healthy, {say: {text: well}}]}"
    path.write_text(
        "task: t\ntree:\n  sequence:\n"
        f"    - reactive_fallback: [arm_healthy, {{not: holding_object}}]\n    - {kept}\n"
    )
    _, out, _ = call("check", path, "--json")
    old, mixed = json.loads(out)
    assert old["patch"]["text"].strip() == "- fallback: [arm_healthy, {not: holding_object}]"
    assert (mixed["patch"], mixed["hint"][:24]) == (None, "write `while: condition`")


def test_a_rule_is_explained_by_its_code():
    code, out, _ = call("check", "--explain", "r201")
    assert code == 0
    assert out.startswith("R201: ")
    assert "{wiat: {duration_s: 1}}" in out
    code, _, err = call("check", "--explain", "R2011")
    assert code == 2
    assert "did you mean `R201`?" in err
