"""Runs that ended in other ways than by a failure: `explain` names the node and the reason."""

from html import escape
from pathlib import Path

import pytest
from py_trees.common import Status

import behaviours
from app.core import RunOptions, run_task
from app.review import explain, explanation_page
from behaviours import Leaf
from trees.language import describe_leaves

SPOT = "{centre: [1.0, 0.0, 0.1], size: [0.2, 0.2, 0.2]}"


class Clumsy(Leaf):
    """Raises."""

    key = "clumsy"

    def update(self) -> Status:
        return self.success(str(1 / 0))


@pytest.fixture
def record(tmp_path, monkeypatch):
    """Runs a tree in the simulator and explains what it left."""
    monkeypatch.setitem(behaviours.LEAVES, Clumsy.key, Clumsy)
    described = describe_leaves(behaviours.LEAVES)
    monkeypatch.setattr("trees.language.registry.declared_leaves", lambda: dict(described))

    def run(tree: str):
        path = tmp_path / "toy.yaml"
        path.write_text(f"task: toy\nregions: {{spot: {SPOT}}}\ntree: {tree}\n")
        options = RunOptions(tree=path, scene="single", record=tmp_path, recording=False)
        told = explain(run_task(options).folder)
        return told, str(told)

    return run


def test_a_motion_that_is_not_done_in_time_is_told_with_its_figures(record):
    told, text = record(
        "{sequence: [{wait: {duration_s: 0.1}}, {drive: {forward_m: 9, timeout_s: 0.4}}]}"
    )
    assert told.node.path == "sequence/drive"
    assert told.reason in text
    assert told.since == pytest.approx(0.52, abs=0.03)
    assert told.values["goal distance [m]"] > 8.0
    assert "goal distance [m]" in text
    assert "0.10 s  ✔ wait: waited" in text


def test_a_crash_in_a_leaf_of_a_name_that_others_have_too(record):
    told, text = record(
        "{sequence: [{name: same, wait: {duration_s: 0.05}}, {name: same, clumsy: }]}"
    )
    assert told.outcome == "crash"
    assert told.node.path == "sequence/same 2"
    assert told.reason == "ZeroDivisionError: division by zero"
    assert Path(__file__).name in told.code
    assert told.code in text


def test_a_success_is_told_with_what_went_wrong_on_the_way(record):
    _, text = record("{fallback: [holding_object, {wait: {duration_s: 0.1}}]}")
    assert "It succeeded: wait: waited" in text
    assert "✗ holding_object" in text
    assert "At that moment" not in text


def test_the_page_is_one_light_file_with_the_cause_first_and_a_map_with_the_way(record):
    told, _ = record("{sequence: [drive: {forward_m: 0.2}, {name: <b>, holding_object: }]}")
    page = explanation_page(told)
    assert len(page) < 1_000_000
    assert "<script" not in page
    assert "http" not in page
    assert "<b>" not in page.partition("</style>")[2]
    cause = page.index(f'<p class="cause">{escape(told.headline)}')
    assert cause < page.index('<polyline class="track"') < page.index("What happened")
    assert '<polygon class="furniture"' in page
    assert '<polygon class="region"' in page
