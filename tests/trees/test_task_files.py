"""Task files as a whole: all errors at once, overrides, files that cannot be read."""

from __future__ import annotations

import pytest
from toy_task import FIRST, HEAD, errors
from tree_toys import TOYS

from trees.language import TaskFileError, build, check, load


def test_all_mistakes_of_a_file_are_reported_at_once_in_its_order(tmp_path):
    text = (
        "task: toy\n"
        "poses:\n"
        "  home: {xyz: [1, 2], rpy_deg: [0, 0, 0]}\n"
        "tree:\n"
        "  sequence:\n"
        "    - navigate: {to: home, timeout_s: soon}\n"
        "    - opn_gripper\n"
    )
    found = errors(tmp_path, text)
    assert [line.split(": ")[0] for line in found] == ["3:15", "6:39", "7:7"]
    with pytest.raises(TaskFileError) as raised:
        load(tmp_path / "t.yaml", leaves=TOYS)
    assert str(raised.value).splitlines() == [f"{tmp_path / 't.yaml'}:{line}" for line in found]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("count=many", "3:3: `-p count=many`: expected a whole number, got the text `many`;"),
        ("count=2.5", "3:3: `-p count=2.5`: expected a whole number, got the number `2.5`;"),
        ("speed=.nan", "4:3: `-p speed=nan`: expected a number, got the number `nan`;"),
        ("cuont=2", "2:1: `-p cuont=2`: the task has no parameter `cuont`; did you mean `count`?"),
    ],
)
def test_mistake_in_an_override(tmp_path, override, message):
    name, value = override.split("=")
    [found] = errors(tmp_path, HEAD + "  open_gripper\n", overrides={name: value})
    assert found.startswith(message)


def test_files_that_cannot_be_read(tmp_path):
    def only(path):
        [diagnostic] = check(path, leaves=TOYS)
        return str(diagnostic)

    missing = tmp_path / "missing.yaml"
    assert only(missing) == f"{missing}: there is no such file; check the path"
    assert only(tmp_path) == (
        f"{tmp_path}: the file cannot be read (Is a directory); name a readable file"
    )
    latin = tmp_path / "latin.yaml"
    latin.write_bytes(b"task: toy\ndescription: H\xc3\xb6he f\xfcr\n")
    assert (
        only(latin)
        == f"{latin}:2:20: the file cannot be read: byte 0xfc is not UTF-8 text; save it as UTF-8"
    )
    large = tmp_path / "large.yaml"
    large.write_text("#" * 64_001)
    assert only(large) == f"{large}: the file is larger than 64 kB; split it into smaller files"


def test_a_leaf_may_refuse_its_parameters_when_the_tree_is_built(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(HEAD + "  grasp: {within: box, lock_distance_m: 2}\n")
    task = load(path, leaves=TOYS)
    with pytest.raises(TaskFileError) as raised:
        build(task, None)
    assert str(raised.value) == (
        f"{path}:{FIRST}:3: `grasp` refuses its parameters: the lock distance is longer than the"
        " arm; change them"
    )


def test_what_nothing_uses_is_a_warning_and_the_task_still_loads(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(HEAD + "  {retry: $count, navigate: {to: home}}\n")
    found = [str(diagnostic).removeprefix(f"{path}:") for diagnostic in check(path, leaves=TOYS)]
    assert found == [
        "4:3: warning: the parameter `speed` is never used; write `$speed` somewhere, or remove it",
        "7:3: warning: `dock` is never used; name it in the tree, or remove it",
        "8:3: warning: `folded` is never used; name it in the tree, or remove it",
        "10:3: warning: `box` is never used; name it in the tree, or remove it",
    ]
    assert len(load(path, leaves=TOYS).warnings) == 4


def test_an_old_name_works_and_is_warned_of(tmp_path, monkeypatch):
    monkeypatch.setattr("trees.language.aliases.WORDS", {"series": "sequence"})
    path = tmp_path / "t.yaml"
    path.write_text(
        "task: t\nposes: {home: {xyz: [1, 0, 1], rpy_deg: [180, 0, 0]}}\n"
        "tree:\n  series:\n    - navigate: {to: home, onward: home}\n"
    )
    old, onward = map(str, check(path))
    assert old.endswith(
        ":4:3: warning: `series` is now called `sequence`; write `sequence`: "
        "`series` will be removed"
    )
    assert f"{path}:5:28: warning: `onward` is now called `next_goal`" in onward
    [navigate] = load(path).root.children
    assert navigate.arguments["next_goal"].name == "home"
