"""How trees are laid out, and what of a large one is drawn."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sample_run as samples
from recordings import record, rows, with_component
from sample_run import FAILURE, IDLE, RUNNING, SUCCESS

from app.live.monitor.tree_drawing import MOST_SHOWN, ROW, list_layout, visible
from app.live.nodes import NodeInfo, NodeStatus, parents

LARGE = (
    NodeInfo(name="root", kind="sequence", depth=0),
    *(
        NodeInfo(name=f"{name} {part}", kind="sequence" if part == 0 else "wait", depth=depth)
        for name in ("first", "second", "third")
        for part, depth in ((0, 1), *((i, 2) for i in range(1, 20)))
    ),
)
"""A root with three sequences of nineteen leaves."""


def statuses(root, first, second, third) -> list[NodeStatus]:
    """Of the large tree: the root's, and of each sequence its own and those of its leaves."""
    row = [root, *(status for part in (first, second, third) for status in part)]
    return [NodeStatus(status, "") for status in row]


def part(own, *leaves, rest=IDLE):
    return [own, *leaves, *[rest] * (19 - len(leaves))]


OPEN_SECOND = (0, 1, *range(21, 41), 41)


@pytest.mark.parametrize(
    ("nodes", "drawn"),
    [
        ((RUNNING, (SUCCESS, SUCCESS), (RUNNING, RUNNING), (IDLE, IDLE)), OPEN_SECOND),
        ((FAILURE, (SUCCESS, SUCCESS), (FAILURE, FAILURE), (IDLE, IDLE)), OPEN_SECOND),
        ((IDLE, (IDLE, IDLE), (IDLE, IDLE), (IDLE, IDLE)), (0, 1, 21, 41)),
    ],
    ids=["running", "failed", "before the first tick"],
)
def test_of_a_large_tree_only_what_runs_or_failed_is_open(nodes, drawn) -> None:
    root, (first, rest), (second, leaf), (third, last) = nodes
    second_part = part(second, *([] if leaf is IDLE else [SUCCESS, leaf]))
    row = statuses(root, part(first, rest=rest), second_part, part(third, rest=last))
    assert visible(LARGE, row) == drawn
    small = [NodeStatus(IDLE, "") for _ in samples.TREE]
    assert visible(samples.TREE, small) == tuple(range(len(samples.TREE)))


@pytest.mark.parametrize("tree", [samples.TREE, LARGE, LARGE[:1], LARGE[:2]])
def test_pills_have_a_row_each_and_edges_lead_from_parent_to_child(tree) -> None:
    layout = list_layout(tree)
    assert layout.left.min() == 0.0
    assert np.diff(layout.height) == pytest.approx(ROW)
    children = [c for c, p in enumerate(parents(tree)) if p is not None]
    assert len(layout.edges) == len(children) == len(tree) - 1
    for child, edge in zip(children, layout.edges, strict=True):
        assert edge[-1, 1] == layout.height[child]
        assert layout.left[child] <= edge[-1, 0] <= layout.left[child] + layout.width[child]


def test_a_large_tree_is_drawn_anew_when_something_opens(tmp_path: Path) -> None:
    first = statuses(RUNNING, part(RUNNING, RUNNING), part(IDLE), part(IDLE))
    second = statuses(RUNNING, part(SUCCESS, rest=SUCCESS), part(RUNNING, RUNNING), part(IDLE))
    run = [
        replace(snapshot, nodes=tuple(first if snapshot.tick < 10 else second))
        for snapshot in samples.run(20)
    ]
    path = record(tmp_path / "x.rrd", run, tree=LARGE)
    pills = with_component(path, "/tree/list/pills", "strips")
    assert [(row["tick"], len(row["strips"])) for row in pills] == [(0, 23), (10, 23)]
    labels = [row["labels"] for row in with_component(path, "/tree/list/labels", "labels")]
    assert labels[0][-2:] == ["· → second 0  +19", "· → third 0  +19"]
    assert labels[1][1] == "✔ → first 0  +19"
    colours = with_component(path, "/tree/list/edges", "colors")
    assert [len(row["colors"]) for row in colours] == [22, 22]
    heights = [strip[0][1] for strip in pills[0]["strips"]]
    assert np.diff(heights) == pytest.approx(ROW)
    assert len(LARGE) > MOST_SHOWN


def test_a_click_on_a_pill_tells_name_kind_status_and_message(tmp_path: Path) -> None:
    path = record(tmp_path / "x.rrd", list(samples.run(40)))
    (fixed,) = with_component(path, "/tree/list/pills", "name")
    assert (fixed["name"][4], fixed["kind"][4]) == ("region empty?", "region_empty")
    last = with_component(path, "/tree/list/pills", "status")[-1]
    assert (last["status"][4], last["message"][4]) == ("FAILURE", "nothing held")


def test_the_blackboard_is_a_table_that_is_kept_when_it_changes(tmp_path: Path) -> None:
    run = [
        replace(snapshot, blackboard={"tries": 1 + snapshot.tick // 20, "a|b": "x\ny"})
        for snapshot in samples.run(40)
    ]
    path = record(tmp_path / "x.rrd", run)
    texts = [(row["tick"], row["text"][0]) for row in rows(path, "/blackboard")]
    assert [tick for tick, _ in texts] == [0, 20]
    assert texts[1][1].splitlines()[2:] == ["| a\\|b | x y |", "| tries | 2 |"]
