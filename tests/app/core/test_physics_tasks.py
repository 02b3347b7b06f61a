"""The shipped tasks in the physical world: what they say they did, contacts alone have done."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_shipped_tasks import run

from trees.language import check

pytest.importorskip("mujoco", reason="needs the extra `physics`")


def physically(record: Path, task: str, *arguments: object) -> dict:
    """The summary of a run that has succeeded and kept to its limits."""
    code, summary, folder = run(record, task, "--world", "physics", *arguments)
    assert (code, summary["world"]) == (0, "physics")
    assert summary["limit_violations"] == 0
    hit = [text for text in summary["contacts_by_name"] if text.startswith(("the base", "link"))]
    assert hit == []
    assert check(folder / "task.yaml") == []  # its parts are kept with it, to run it again
    return summary


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_the_container_is_emptied(tmp_path, seed):
    summary = physically(tmp_path, "pick_place", "--seed", seed)
    assert summary["placed"] >= 9
    assert summary["placed"] == summary["claimed"]


@pytest.mark.slow
def test_two_tables_are_tidied(tmp_path):
    summary = physically(tmp_path, "tidy_two_tables", "--seed", 1)
    assert summary["messages"] == ["Both tables are clear."]
    assert (summary["placed"], summary["objects"]) == (4, 4)


@pytest.mark.slow
@pytest.mark.parametrize(("task", "objects"), [("clear_counter", 5), ("restock_shelf", 6)])
def test_a_tilted_hand_works_on_a_counter_and_in_a_shelf(tmp_path, task, objects):
    summary = physically(tmp_path, task, "--seed", 1)
    assert (summary["placed"], summary["objects"]) == (objects, objects)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "message"),
    [
        ("follow_moving_object", "I have it."),
        ("inspect", "I count 6 objects on the bench."),
        ("patrol", "All is quiet."),
    ],
)
def test_the_other_tasks_succeed_too(tmp_path, task, message):
    assert message in physically(tmp_path, task)["messages"]
