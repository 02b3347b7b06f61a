"""Warnings: what a task file may say, and hardly means."""

from command_line import call
from mistakes import table
from tree_toys import TOYS

from config import Severity
from trees.language import check


def warnings(folder, tree: str) -> list[str]:
    path = folder / "t.yaml"
    lines = "\n".join(f"  {line}" for line in tree.strip().splitlines())
    path.write_text(f"task: toy\ntree:\n{lines}\n")
    found = check(path, leaves=TOYS)
    assert all(diagnostic.severity is Severity.WARNING for diagnostic in found), found
    return [
        f"{diagnostic.location.line - 2}:{diagnostic.location.column - 2}: {diagnostic.message}"
        for diagnostic in found
    ]


@table("odd")
def test_what_is_odd_is_a_warning(tmp_path, row):
    found = [text for text in warnings(tmp_path, row["task"]) if "cannot succeed:" not in text]
    assert [text.split(": ", 1)[1] for text in found] == [row["tells"]]


@table("sound")
def test_what_is_meant_is_no_warning(tmp_path, row):
    assert warnings(tmp_path, row) == []


ASKED = "ask: {answers: S}"


def test_warnings_are_where_the_node_is(tmp_path):
    assert warnings(tmp_path, f"sequence:\n  - {ASKED}\n  - open_gripper")[0].startswith("2:5: ")


def test_what_only_a_subtree_can_tell(tmp_path):
    (tmp_path / "sure.yaml").write_text(
        "task: sure\ntree: {force_success: true, play: {script: S}}\n"
    )
    [found] = warnings(tmp_path, "fallback: [subtree: {file: sure.yaml}, open_gripper]")
    assert "`open_gripper` is never reached: `sure` before it never fails" in found


def test_a_file_with_warnings_alone_passes(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text("task: t\nparams: {a: {default: 1}}\ntree: open_gripper\n")
    code, out, _ = call("check", path)
    assert code == 0
    assert f"{path}:2:10: warning: the parameter `a` is never used; " in out
    assert f"{path}: good" in out
