"""`explain` names what went wrong first, for failed runs of the real application of many kinds."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import test_explain
from failed_runs import CASES, FETCH, HEAD, PICK, SLOW, fault

from app.core import RunOptions, run_task
from app.review import explain
from trees.language import describe_leaves


@pytest.fixture
def record(tmp_path, monkeypatch):
    """Runs a tree and explains what it left."""
    import behaviours

    for leaf in (test_explain.CloseFingers, test_explain.Sabotage):
        monkeypatch.setitem(behaviours.LEAVES, leaf.key, leaf)
    described = describe_leaves(behaviours.LEAVES)
    monkeypatch.setattr("trees.language.registry.declared_leaves", lambda: dict(described))

    def run(tree: str, interrupted=lambda: False, **options):
        path = tmp_path / "toy.yaml"
        path.write_text(HEAD + "".join(f"  {line}\n" for line in tree.strip().splitlines()))
        chosen = {"scene": "single", "recording": False, "record": tmp_path / "runs"}
        options = RunOptions(tree=path, **(chosen | options))
        return explain(run_task(options, interrupted=interrupted).folder)

    return run


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=[pytest.mark.slow] * (name in SLOW)) for name, case in CASES.items()],
    ids=CASES,
)
def test_the_earliest_cause_is_named(record, case):
    told = record(case.tree, faults=case.faults, **case.options)
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


def test_every_failed_attempt_is_in_the_table_with_its_reason(record):
    told = record(PICK.format(attempts=3))
    assert [attempt.cause.topic for attempt in told.attempts] == ["no grasp found"] * 3
    text = str(told)
    assert text.count("pick: no grasp found: grasp: no grasp for 0.3 s") == 3


@pytest.mark.slow
def test_attempts_that_failed_in_different_ways_are_told_apart(record):
    told = record(
        FETCH, faults=(fault("gripper dead", at_s=0.5, for_s=6.0), fault("frames lost", at_s=6.0))
    )
    assert [attempt.cause.topic for attempt in told.attempts] == [
        "the gripper does not work",
        "no picture",
    ]
    assert told.reason.startswith("no grasp for")
    text = str(told)
    assert text.index("The gripper does not work: grasp") < text.index("it ended when grasp")


def test_what_took_the_time_adds_up(record):
    told = record("sequence: [{wait: {duration_s: 3}}, {wait: {duration_s: 1}}, holding_object]")
    assert [(one.name, round(one.seconds)) for one in told.leaf_times] == [
        ("sequence > wait", 3),
        ("sequence > wait 2", 1),
    ]
    assert re.search(r"sequence > wait +3\.0 s +75 %", str(told))


def test_an_interrupted_run_tells_what_had_failed_before(record):
    ticks = iter(range(100))
    tree = "retry: 9\nsequence: [{wait: {duration_s: 0.2}}, holding_object]"
    told = record(tree, interrupted=lambda: next(ticks, None) is None)
    assert told.outcome == "interrupted"
    assert (told.where.name, told.cause.time) == ("holding_object", pytest.approx(0.2, abs=0.05))
    assert "what went wrong first: " in str(told)


def test_a_killed_run_tells_what_had_failed_before(tmp_path):
    task = tmp_path / "toy.yaml"
    work = "[{wait: {duration_s: 0.3}}, {grasp: {within: floor, patience_s: 1.0}}]"
    task.write_text(f"{HEAD}  {{retry: 99, sequence: {work}}}\n")
    command = [sys.executable, "-m", "frankie_task_cli", "run", task, "--scene", "single"]
    command += ["--record", tmp_path / "runs", "--speed", "real", "--view", "none"]
    process = subprocess.Popen(
        list(map(str, command)),
        stderr=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])},
    )
    try:
        deadline = time.monotonic() + 60.0
        log = ""
        while log.count('"FAILURE", "message": "no grasp') < 2 and time.monotonic() < deadline:
            assert process.poll() is None
            time.sleep(0.1)
            log = "".join(p.read_text() for p in tmp_path.glob("runs/*/events.jsonl"))
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    (folder,) = (tmp_path / "runs").iterdir()
    with (folder / "events.jsonl").open("a") as file:
        file.write('{"event": "node", "ti')  # a line that the kill cut off
    told = explain(folder)
    text = str(told)
    assert told.outcome == "unfinished"
    assert "was killed" in text
    assert told.cause.topic == "no grasp found"
    assert 1.0 < told.cause.time < 2.0
    assert "what went wrong first: No grasp found: grasp failed at 1." in text
    assert len(told.attempts) >= 2
