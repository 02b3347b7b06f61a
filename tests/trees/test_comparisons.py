"""The conditions on values, as a task file uses them."""

from __future__ import annotations

import pytest
from py_trees.common import Status
from tree_toys import ToyContext

from trees.language import TaskFileError, build, load


@pytest.fixture
def outcome(tmp_path):
    """Status and message of a tree after one tick."""

    def run(tree: str) -> tuple[Status, str]:
        path = tmp_path / "t.yaml"
        path.write_text(f"task: toy\ntree: {tree}\n")
        root = build(load(path), ToyContext())
        root.tick_once()
        return root.status, root.feedback_message

    return run


@pytest.mark.parametrize(
    ("value", "to", "status"),
    [
        ("left", "left", Status.SUCCESS),
        ("left", "right", Status.FAILURE),
        ("3", "3.0", Status.SUCCESS),
        ("true", "true", Status.SUCCESS),
    ],
)
def test_equals(outcome, value, to, status):
    tree = f"{{sequence: [set: {{v: {value}}}, equals: {{value: $v, to: {to}}}]}}"
    assert outcome(tree)[0] is status


@pytest.mark.parametrize(("value", "to"), [("3", "'3'"), ("true", "1"), ("0", "false")])
def test_values_of_different_kinds_cannot_be_compared(outcome, value, to):
    tree = f"{{sequence: [set: {{v: {value}}}, equals: {{value: $v, to: {to}}}]}}"
    with pytest.raises(TaskFileError, match="which are never equal"):
        outcome(tree)


@pytest.mark.parametrize(
    ("value", "status"), [("2", Status.SUCCESS), ("2.5", Status.SUCCESS), ("1", Status.FAILURE)]
)
def test_at_least(outcome, value, status):
    tree = f"{{sequence: [set: {{v: {value}}}, at_least: {{value: $v, least: 2}}]}}"
    assert outcome(tree) == (status, f"at_least: {value} of at least 2")


def test_a_comparison_can_guard(outcome):
    tree = "{sequence: [set: {n: 0}, {while: {at_least: {value: $n, least: 1}}, open_gripper: }]}"
    assert outcome(tree) == (Status.FAILURE, "at_least: 0 of at least 1")
