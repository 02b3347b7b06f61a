"""The commands for whoever writes tasks, as a person meets them."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from command_line import call

from behaviours import LEAVES
from trees.language import COMPOSITES, MODIFIERS

BROKEN = "task: broken\ntree:\n  sequence:\n    - open_griper\n"


@pytest.fixture
def broken(tmp_path) -> Path:
    path = tmp_path / "broken.yaml"
    path.write_text(BROKEN)
    return path


# nodes


def test_nodes_lists_every_word_with_what_it_takes():
    code, out, _ = call("nodes")
    assert code == 0
    first = {line.split()[0].rstrip(":;") for line in out.splitlines()}
    assert {*LEAVES, *COMPOSITES, *MODIFIERS, "name", "subtree", "set"} <= first
    (grasp,) = [line for line in out.splitlines() if line.startswith("grasp: ")]
    assert "within, [choose]" in grasp


def test_nodes_tells_all_about_one():
    _, out, _ = call("nodes", "grasp")
    (line,) = [line for line in out.splitlines() if line.startswith("  lock_distance_m")]
    for part in ("a number", "[m]", "(0.25)", "nearer than this to the camera"):
        assert part in line
    for word in ("wait", "parallel", "retry", "name", "subtree", "set"):
        code, out, _ = call("nodes", word)
        assert (code, out.startswith(word)) == (0, True)
    _, out, _ = call("nodes", "scan_for_objects")
    assert "  count: a key that takes a whole number" in out


def test_an_unknown_word_gets_a_suggestion():
    code, out, err = call("nodes", "graps")
    assert (code, out) == (2, "")
    assert "did you mean `grasp`?" in err
    assert err.count("\n") == 1


# draw


def test_draw_prints_or_writes_a_picture(tmp_path):
    code, out, _ = call("draw", "pick_one")
    assert code == 0
    assert "pick (sequence)  [retry: $attempts]" in out
    picture = tmp_path / "tree.txt"
    code, told, _ = call("draw", "pick_one", "--output", picture)
    assert (code, told) == (0, f"{picture}: written\n")
    assert picture.read_text() == out


@pytest.mark.parametrize("command", ["draw", "export"])
def test_a_task_with_mistakes_is_located(broken, command):
    code, out, err = call(command, broken)
    assert (code, out) == (2, "")
    assert err.startswith(f"{broken}:4:7: ")
    assert "did you mean `open_gripper`" in err


# schema


def test_schema_prints_json():
    code, out, _ = call("schema")
    assert code == 0
    assert "grasp" in json.loads(out)["definitions"]["node"]["properties"]


# new


def test_a_new_task_is_sound_complete_for_the_editor_and_runs(tmp_path):
    code, out, _ = call("new", "tidy_up", "--folder", tmp_path)
    task = tmp_path / "tidy_up.yaml"
    assert code == 0
    assert str(task) in out
    assert call("check", task) == (0, f"{task}: good\n", "")
    assert task.read_text().startswith("# yaml-language-server: $schema=frankie-task.schema.json\n")
    assert json.loads((tmp_path / "frankie-task.schema.json").read_text())
    code, out, _ = call("dry", task)
    assert (code, "tidy_up, dry: success" in out) == (0, True)


def test_new_writes_over_nothing(tmp_path):
    (tmp_path / "mine.yaml").write_text("precious")
    (tmp_path / "frankie-task.schema.json").write_text("mine too")
    code, _, err = call("new", "mine", "--folder", tmp_path)
    assert code == 2
    assert "already exists" in err
    assert (tmp_path / "mine.yaml").read_text() == "precious"
    assert call("new", "other", "--folder", tmp_path)[0] == 0
    assert (tmp_path / "frankie-task.schema.json").read_text() == "mine too"


def test_a_bad_name_is_refused(tmp_path):
    code, _, err = call("new", "../up", "--folder", tmp_path)
    assert code == 2
    assert "letters, digits and `_`" in err
    assert list(tmp_path.iterdir()) == []


# export and reach


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
