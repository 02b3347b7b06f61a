"""What composites and modifiers do, tick by tick, in simulated time."""

from __future__ import annotations

import pytest
from py_trees.common import Status
from tree_toys import Run


@pytest.fixture
def run(tmp_path):
    return lambda tree: Run(tmp_path, tree)


def test_sequence_continues_where_it_was_and_stops_at_the_first_failure(run):
    tree = run("""
sequence:
  - {name: a, play: {script: S}}
  - {name: b, play: {script: RRF}}
  - {name: c, play: {script: S}}
""")
    assert tree.ticks(3) == "RRF"
    assert tree.events == ["a begins", "a ends S", "b begins", "b ends F"]
    assert tree.root.feedback_message == "b: said F"


def test_fallback_takes_the_first_success(run):
    tree = run("""
fallback:
  - {name: a, play: {script: RF}}
  - {name: b, play: {script: RS}}
  - {name: c, play: {script: S}}
""")
    assert tree.ticks(3) == "RRS"
    assert tree.begun("a") == 1
    assert tree.begun("c") == 0


def test_reactive_sequence_halts_the_action_when_its_guard_fails(run):
    tree = run("""
reactive_sequence:
  - {name: guard, play: {script: SSF}}
  - {name: action, play: {script: R}}
""")
    assert tree.ticks(3) == "RRF"
    assert tree.events.count("action ends I") == 1
    assert tree.root.feedback_message == "guard: said F"


def test_reactive_fallback_returns_to_an_earlier_child(run):
    tree = run("""
reactive_fallback:
  - {name: first, play: {script: FR}}
  - {name: second, play: {script: R}}
""")
    assert tree.ticks(2) == "RR"
    assert tree.events.count("second ends I") == 1


def test_until_works_until_its_question_is_answered_with_success(run):
    tree = run("""
until:
  - {name: question, play: {script: RFFS}}
  - {name: work, play: {script: RSS}}
  - {name: more, play: {script: S}}
""")
    assert tree.ticks(5) == "RRRRS"
    assert [event for event in tree.events if "begins" in event] == [
        *("question begins", "work begins", "more begins"),
        *("question begins", "work begins", "more begins"),
        "question begins",
    ]
    assert tree.root.feedback_message == "question: said S"


def test_wait_until_asks_at_every_tick(run):
    tree = run("wait_until: {ask: {answers: FFS}}")
    assert tree.ticks(3) == "RRS"


def test_repeat_needs_every_round_to_succeed(run):
    assert run("{repeat: 3, play: {script: SRSS}}").ticks(4) == "RRRS"
    assert run("{repeat: 2, play: {script: S}}").ticks(4) == "RSRS"
    failing = run("{repeat: 3, name: turn, play: {script: SF}}")
    assert failing.ticks(2) == "RF"
    assert failing.root.feedback_message == "round 2 of 3: turn: said F"


def test_invert_swaps_outcomes_and_leaves_running_alone(run):
    assert run("{invert: true, play: {script: RFS}}").ticks(3) == "RSF"
    assert run("{invert: false, play: {script: RFS}}").ticks(3) == "RFS"


def test_timeout_counts_simulated_time_and_halts_what_is_late(run):
    tree = run("{name: slow, timeout_s: 0.05, play: {script: R}}")
    assert tree.ticks(6) == "RRRRRF"
    assert tree.events == ["slow begins", "slow ends I"]
    assert tree.root.feedback_message == "not done within 0.05 s (slow: said R)"


def test_each_attempt_has_the_whole_timeout(run):
    tree = run("{retry: 2, timeout_s: 0.02, name: slow, play: {script: R}}")
    assert tree.ticks(6) == "RRRRRF"
    assert tree.begun("slow") == 2


def test_a_halt_reaches_every_running_leaf_once_and_no_other(run):
    tree = run("""
sequence:
  - {name: done, play: {script: S}}
  - retry: 2
    timeout_s: 9
    parallel:
      - {name: finished, play: {script: S}}
      - {name: a, play: {script: R}}
      - forever: {name: b, play: {script: R}}
  - {name: later, play: {script: S}}
""")
    tree.ticks(2)
    tree.events.clear()
    tree.root.stop(Status.INVALID)
    tree.root.stop(Status.INVALID)
    assert tree.events == ["a ends I", "b ends I"]
    assert all(node.status is Status.INVALID for node in tree.root.iterate())


def test_an_exception_passes_through_and_a_halt_still_reaches_the_running(run):
    tree = run("""
retry: 3
parallel:
  - {name: a, play: {script: R}}
  - {name: b, play: {script: X}}
""")
    with pytest.raises(RuntimeError, match=r"^b broke$"):
        tree.ticks(1)
    tree.root.stop(Status.INVALID)
    assert tree.events == ["a begins", "b begins", "a ends I"]
