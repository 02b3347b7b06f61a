"""Warnings: what a task file may say, and hardly means."""

from __future__ import annotations

import pytest
from command_line import call
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


ACT = "play: {script: S}"
ASKED = "ask: {answers: S}"
SURE = f"{{force_success: true, {ACT}}}"
HOPELESS = f"{{force_failure: true, {ACT}}}"

ODD = {
    "fallback after what cannot fail": (
        f"fallback: [{SURE}, open_gripper]",
        "`open_gripper` is never reached: `play` before it never fails",
    ),
    "sequence after what cannot succeed": (
        f"sequence: [{HOPELESS}, open_gripper]",
        "`open_gripper` is never reached: `play` before it never succeeds",
    ),
    "parallel of what cannot fail": (
        f"fallback: [parallel: [{SURE}, {SURE}], open_gripper]",
        "`open_gripper` is never reached: `parallel` before it never fails",
    ),
    "retry of what cannot fail": (
        f"{{retry: 2, sequence: [{SURE}]}}",
        "`retry` has no effect on `sequence`: it cannot fail",
    ),
    "timeout of a condition": (
        f"{{timeout_s: 3, {ASKED}}}",
        "`timeout_s` has no effect on `ask`: it ends at once",
    ),
    "condition asked once": (
        f"sequence: [{ASKED}, open_gripper]",
        "`ask` is asked once, and not again while `open_gripper` runs",
    ),
    "second condition asked once": (
        f"sequence: [{{name: at the start, {ASKED}}}, {ASKED}, set: {{n: 1}}, note: {{value: $n}}]",
        "`ask` is asked once, and not again while `note` runs",
    ),
    "action in a reactive sequence": (
        f"reactive_sequence: [{ACT}, open_gripper]",
        "`play` begins again at every tick after its success",
    ),
}


@pytest.mark.parametrize(("tree", "message"), ODD.values(), ids=ODD)
def test_what_is_odd_is_a_warning(tmp_path, tree, message):
    found = [text for text in warnings(tmp_path, tree) if "cannot succeed:" not in text]
    assert [text.split(": ", 1)[1] for text in found] == [message]


SOUND = [
    f"fallback: [{ACT}, open_gripper]",
    f"fallback: [{{timeout_s: 1, force_success: false, {ACT}}}, open_gripper]",
    f"fallback: [{{while: {{{ASKED}}}, sequence: [{SURE}]}}, open_gripper]",
    f"sequence: [{{invert: true, sequence: [{HOPELESS}]}}, open_gripper]",
    f"sequence: [{{name: at the start, {ASKED}}}, open_gripper]",
    f"sequence: [open_gripper, {ASKED}, open_gripper]",
    f"reactive_sequence: [{ASKED}, open_gripper]",
    f"reactive_sequence: [{{once: true, {ACT}}}, open_gripper]",
    f"{{while: {{{ASKED}}}, sequence: [open_gripper, {ACT}]}}",
    f"sequence: [parallel: {{policy: any, children: [{HOPELESS}, {ACT}]}}, open_gripper]",
    f"{{timeout_s: 3, until: [{ASKED}, {ACT}]}}",
]


@pytest.mark.parametrize("tree", SOUND)
def test_what_is_meant_is_no_warning(tmp_path, tree):
    assert warnings(tmp_path, tree) == []


def test_warnings_are_where_the_node_is(tmp_path):
    assert warnings(tmp_path, f"sequence:\n  - {ASKED}\n  - open_gripper")[0].startswith("2:5: ")


def test_what_only_a_subtree_can_tell(tmp_path):
    (tmp_path / "sure.yaml").write_text(f"task: sure\ntree: {SURE}\n")
    [found] = warnings(tmp_path, "fallback: [subtree: {file: sure.yaml}, open_gripper]")
    assert "`open_gripper` is never reached: `sure` before it never fails" in found


def test_a_file_with_warnings_alone_passes(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text("task: t\nparams: {a: {default: 1}}\ntree: open_gripper\n")
    code, out, _ = call("check", path)
    assert code == 0
    assert f"{path}:2:10: warning: the parameter `a` is never used; " in out
    assert f"{path}: good" in out
