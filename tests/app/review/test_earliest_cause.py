"""`explain` names what went wrong first, for failed runs of the real application of many kinds."""

import re
from pathlib import Path
from typing import NamedTuple

import pytest
from py_trees.common import Status
from recorded_runs import faulty

import behaviours
from app.core import RunOptions, run_task
from app.review import explain
from behaviours import Leaf

HEAD = """\
task: toy
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
  far: {xyz: [-40.0, 0.0, 0.7], rpy_deg: [180, 0, 0]}
  above: {xyz: [2.935, 0.0, 0.85], rpy_deg: [180, 0, 0]}
  under_table: {base: [0.0, 1.6], heading_deg: 0}
regions:
  floor: {centre: [0.7, 0.0, 0.3], size: [0.4, 0.4, 0.6]}
  container: {centre: [3.0, 0.0, 0.556], size: [0.44, 0.36, 0.20]}
tree:
"""


class Case(NamedTuple):
    """A tree whose run fails; node and reason (an expression) of what went wrong first in it."""

    tree: str
    node: str
    reason: str
    topic: str = ""
    outcome: str = "failure"
    faults: tuple[str, ...] = ()
    since: tuple[float, float] = (0.0, 60.0)
    """Between which times the cause is [s]."""


CASES = {
    "a place on the floor inside a table": Case(
        "navigate: {to: under_table}", "navigate", "the base would stand in", "out of reach"
    ),
    "nothing in the hand to be placed": Case(
        "place: {on: floor}", "place", "^nothing to place", "held nothing"
    ),
    "an empty battery and a message about it": Case(
        "sequence: [wait: {duration_s: 1.6}, fallback: [battery_above: {percent: 99.99}, "
        "{force: failure, say: {text: I must charge.}}]]",
        *("battery_above", "^battery at ", "battery"),
    ),
    "a reflex that nothing clears": Case(
        "fallback: [{name: job, sequence: [{navigate: {to: far}}]}, {move_arm: {to: ready}}]",
        *("job/navigate", "reflex of the arm", "a fault of the robot"),
        faults=("reflex@0.5",),
        since=(0.5, 0.52),
    ),
    "a bumper, while a timeout runs": Case(
        "{timeout_s: 1.0, retry: 2, sequence: [{drive: {forward_m: 2}}]}",
        *("drive", "bumper of the base", "a fault of the robot"),
        faults=("bumper@0.3",),
        since=(0.3, 0.32),
    ),
    "an emergency stop with nobody there": Case(
        "navigate: {to: far}",
        *("navigate", "emergency stop", "emergency stop", "hardware fault"),
        faults=("emergency stop@0.4",),
        since=(0.4, 0.42),
    ),
    "a time that was over while one leaf waited": Case(
        "{timeout_s: 0.5, sequence: [{wait: {duration_s: 9}}]}",
        *("timeout", r"^not done within 0\.5 s \(wait", "out of time"),
    ),
    "a time that was over after failed attempts": Case(
        "{timeout_s: 1.0, sequence: ["
        "{retry: 9, sequence: [{wait: {duration_s: 0.3}}, holding_object]}]}",
        *("holding_object", "the fingers"),
        since=(0.3, 0.4),
    ),
    "the remedy after a failure that is expected": Case(
        "fallback: [{name: offer, navigate: {to: far, timeout_s: 0.3}}, "
        "{name: put back, sequence: [{wait: {duration_s: 0.2}}, {place: {on: floor}}]}]",
        *("put back/place", "^nothing to place", "held nothing"),
        since=(0.4, 0.7),
    ),
    "a remedy that fails at once, within an attempt that another one answers": Case(
        "sequence: [{force: success, navigate: {to: far, timeout_s: 0.3}}, "
        "fallback: [{name: offer, navigate: {to: far, timeout_s: 0.3}}, "
        "{name: put back, place: {on: floor}}, "
        "{name: sorry, force: failure, say: {text: Sorry.}}]]",
        *("put back", "^nothing to place"),
        since=(0.5, 0.8),
    ),
    "a question that said no before the work failed": Case(
        "fallback: [holding_object, {navigate: {to: far, timeout_s: 0.3}}]",
        *("navigate", "^not at far"),
    ),
    "one of two at the same time": Case(
        "parallel: [{wait: {duration_s: 5}}, "
        "{name: late, sequence: [{wait: {duration_s: 0.2}}, holding_object]}]",
        *("late/holding_object", "fingers"),
        since=(0.1, 0.3),
    ),
}
LONG = {
    "the object is taken from the hand": Case(
        "{name: pick, retry: 1, sequence: ["
        "{navigate: {to: above}}, {grasp: {within: container}}, retreat_check]}",
        *("pick/retreat_check", "fingers", "held nothing"),
        faults=("object taken@close",),
    ),
    "a base that does not move": Case(
        "navigate: {to: above}",
        *("navigate", "does not do what it is commanded"),
        *("the robot does not obey", "hardware fault"),
        faults=("base ignores commands@0.3",),
    ),
}


class Clumsy(Leaf):
    """Raises."""

    key = "clumsy"

    def update(self) -> Status:
        return self.success(str(1 / 0))


@pytest.fixture
def record(tmp_path, monkeypatch):
    """Runs a tree and explains what it left."""
    monkeypatch.setitem(behaviours.LEAVES, Clumsy.key, Clumsy)

    def run(tree: str, interrupted=lambda: False, **options):
        path = tmp_path / "toy.yaml"
        path.write_text(HEAD + "".join(f"  {line}\n" for line in tree.splitlines()))
        chosen = {"scene": "single", "recording": False, "record": tmp_path / "runs"}
        options = RunOptions(tree=path, **(chosen | options))
        return explain(run_task(options, interrupted=interrupted).folder)

    return run


@pytest.mark.parametrize(
    "case",
    [
        *(pytest.param(case, id=name) for name, case in CASES.items()),
        *(pytest.param(case, id=name, marks=pytest.mark.slow) for name, case in LONG.items()),
    ],
)
def test_the_earliest_cause_is_named(record, case):
    told = record(case.tree, **faulty(*case.faults))
    text = str(told)
    assert told.outcome == case.outcome, text
    assert told.cause is not None, text
    assert told.where.path.endswith(case.node), text
    assert re.search(case.reason, told.cause.reason), text
    assert told.cause.topic == case.topic or not case.topic, text
    assert case.since[0] - 0.02 <= told.cause.time <= case.since[1], text
    first = text.split("\n\n")[1].splitlines()
    assert any(told.cause.reason in line for line in first[:2]), text
    assert told.where.name in "".join(first), text


def pick(retry: int, goal: str, within: str) -> str:
    steps = f"recover, navigate: {{to: {goal}}}, open_gripper, grasp: {{{within}}}, retreat_check"
    return f"{{name: pick, retry: {retry}, sequence: [{steps}]}}"


def test_every_failed_attempt_is_in_the_table_with_its_reason(record):
    told = record(pick(2, "near", "within: floor, patience_s: 0.3"))
    assert [attempt.cause.topic for attempt in told.attempts] == ["no grasp found"] * 2
    assert told.cause.time == told.attempts[0].cause.time
    assert str(told).count("pick: no grasp found: grasp: no grasp for 0.3 s") == 2


@pytest.mark.slow
def test_attempts_that_failed_in_different_ways_are_told_apart(record):
    faults = faulty("gripper dead@0.5 for 6", "frames lost@6")
    told = record(pick(2, "above", "within: container"), **faults)
    topics = [attempt.cause.topic for attempt in told.attempts]
    assert topics == ["the gripper does not work", "no picture"]
    text = str(told)
    assert text.index("The gripper does not work: grasp") < text.index("it ended when grasp")


def test_what_took_the_time_adds_up(record):
    told = record(
        "sequence: [{wait: {duration_s: 1.5}}, {wait: {duration_s: 0.5}}, holding_object]"
    )
    times = {one.name: one.seconds for one in told.leaf_times}
    assert times == pytest.approx({"sequence > wait": 1.5, "sequence > wait 2": 0.5}, abs=0.05)
    assert re.search(r"1\.5 s +7\d % +1 round +sequence > wait\n", str(told))


def test_an_interrupted_run_tells_what_had_failed_before(record):
    ticks = iter(range(100))
    tree = "retry: 9\nsequence: [{wait: {duration_s: 0.2}}, holding_object]"
    told = record(tree, interrupted=lambda: next(ticks, None) is None)
    assert told.outcome == "interrupted"
    assert (told.where.name, told.cause.time) == ("holding_object", pytest.approx(0.2, abs=0.05))
    assert "what went wrong first: " in str(told)


def test_a_killed_run_tells_what_had_failed_before(record, tmp_path):
    drive = "{drive: {forward_m: 9, timeout_s: 0.2}}"
    record(f"retry: 3\nsequence: [{{wait: {{duration_s: 0.3}}}}, {drive}]")
    (folder,) = (tmp_path / "runs").iterdir()
    (folder / "summary.json").unlink()
    events = folder / "events.jsonl"
    lines = events.read_text().splitlines(keepends=True)
    second = [n for n, line in enumerate(lines) if '"FAILURE", "message": "not ' in line][1]
    events.write_text("".join(lines[: second + 1]) + '{"event": "node", "ti')
    told = explain(folder)
    text = str(told)
    assert told.outcome == "unfinished"
    assert "was killed" in text
    assert told.where.name == "drive"
    assert re.search(r"what went wrong first: .*drive failed at 0.5", text)
    assert len(told.attempts) == 2


def test_a_motion_that_is_not_done_in_time_is_told_with_its_figures(record):
    drive = "{drive: {forward_m: 9, timeout_s: 0.4}}"
    told = record(f"{{sequence: [{{wait: {{duration_s: 0.1}}}}, {drive}]}}")
    assert told.node.path == "sequence/drive"
    assert told.since == pytest.approx(0.52, abs=0.03)
    assert told.values["goal distance [m]"] > 8.0
    for part in (told.reason, "goal distance [m]", "0.10 s  ✔ wait → 0.1 s: waited"):
        assert part in str(told)


def test_a_crash_in_a_leaf_of_a_name_that_others_have_too(record):
    told = record("{sequence: [{name: same, wait: {duration_s: 0.05}}, {name: same, clumsy: }]}")
    assert (told.outcome, told.node.path) == ("crash", "sequence/same 2")
    assert told.reason == "ZeroDivisionError: division by zero"
    assert Path(__file__).name in told.code
    assert told.code in str(told)


def test_a_success_is_told_with_what_went_wrong_on_the_way(record):
    text = str(record("{fallback: [holding_object, {wait: {duration_s: 0.1}}]}"))
    assert "It succeeded: wait: waited" in text
    assert "○ holding_object" in text
    assert "At that moment" not in text
