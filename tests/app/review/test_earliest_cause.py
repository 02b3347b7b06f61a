"""`explain` names what went wrong first, for failed runs of the real application of many kinds."""

import re

import pytest
from failed_runs import CASES, FETCH, HEAD, PICK, SLOW, fault

from app.core import RunOptions, run_task
from app.review import explain


@pytest.fixture
def record(tmp_path):
    """Runs a tree and explains what it left."""

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
    told = record(case.tree, faults=case.faults)
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
    told = record(PICK.format(attempts=2))
    assert [attempt.cause.topic for attempt in told.attempts] == ["no grasp found"] * 2
    assert told.cause.time == told.attempts[0].cause.time
    assert str(told).count("pick: no grasp found: grasp: no grasp for 0.3 s") == 2


@pytest.mark.slow
def test_attempts_that_failed_in_different_ways_are_told_apart(record):
    told = record(
        FETCH, faults=(fault("gripper dead", at_s=0.5, for_s=6.0), fault("frames lost", at_s=6.0))
    )
    assert [attempt.cause.topic for attempt in told.attempts] == [
        "the gripper does not work",
        "no picture",
    ]
    text = str(told)
    assert text.index("The gripper does not work: grasp") < text.index("it ended when grasp")


def test_what_took_the_time_adds_up(record):
    told = record("sequence: [{wait: {duration_s: 3}}, {wait: {duration_s: 1}}, holding_object]")
    assert [(one.name, round(one.seconds)) for one in told.leaf_times] == [
        ("sequence > wait", 3),
        ("sequence > wait 2", 1),
    ]
    assert re.search(r"3\.0 s +75 % +1 round +sequence > wait\n", str(told))


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
