"""What composites and modifiers do, tick by tick, in simulated time; `ticks.yaml` has the table."""

from pathlib import Path

import pytest
import yaml
from py_trees.common import Status

from trees.language import MODIFIERS, failed_node

TABLE = yaml.safe_load((Path(__file__).parent / "ticks.yaml").read_text("utf-8"))


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row["what"])
def test_a_word_ticks_as_the_table_says(run, row):
    tree = run(row["tree"])
    if "ends" in row:
        assert tree.to_the_end() == row["ends"]
    else:
        assert tree.ticks(len(row["ticks"])) == row["ticks"]
    assert tree.events == row.get("events", tree.events)
    assert tree.root.feedback_message == row.get("says", tree.root.feedback_message)
    for name, times in row.get("begun", {}).items():
        assert tree.begun(name) == times
    if tree.root.status is not Status.RUNNING:
        assert not any(node.status is Status.RUNNING for node in tree.root.iterate())


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


def test_cooldown_counts_from_a_halt_too(run):
    tree = run("{name: a, cooldown_s: 1, play: {script: R}}")
    tree.ticks(2)
    tree.root.stop(Status.INVALID)
    assert tree.ticks(1) == "F"
    assert tree.begun("a") == 1


def test_once_starts_again_after_a_halt_before_its_end(run):
    tree = run("{name: a, once: true, play: {script: RS}}")
    tree.ticks(1)
    tree.root.stop(Status.INVALID)
    assert tree.ticks(2) == "SS"
    assert tree.begun("a") == 2


UNKNOWN = "{name: q, ask: {answers: R}}"


@pytest.mark.parametrize(
    "tree",
    [
        f"{{while: {UNKNOWN}, play: {{script: S}}}}",
        f"{{unless: {UNKNOWN}, play: {{script: S}}}}",
        f"{{while: {{not: {UNKNOWN}}}, play: {{script: S}}}}",
        f"{{unless: {{not: {UNKNOWN}}}, play: {{script: S}}}}",
        f"{{while: {{all_of: [{UNKNOWN}, {{ask: {{answers: S}}}}]}}, play: {{script: S}}}}",
        f"{{unless: {{any_of: [{{ask: {{answers: F}}}}, {UNKNOWN}]}}, play: {{script: S}}}}",
        f"reactive_fallback: [{UNKNOWN}, play: {{script: S}}]",
        f"sequence: [{UNKNOWN}, play: {{script: S}}]",
        f"parallel: [{UNKNOWN}, {UNKNOWN}]",
        "{invert: true, name: q, ask: {answers: R}}",
        f"{{invert: true, sequence: [{UNKNOWN}]}}",
        f"{{invert: true, fallback: [{UNKNOWN}]}}",
        UNKNOWN,
        f"not: {UNKNOWN}",
        f"any_of: [{UNKNOWN}, {{ask: {{answers: F}}}}]",
    ],
)
def test_what_stays_not_known_fails_whoever_asks_and_nothing_below_it_runs(run, tree):
    tree = run(tree)
    assert tree.ticks(100) == 100 * "R"
    assert tree.ticks(1) == "F"
    assert tree.events == []
    assert failed_node(tree.root).name == "q"


def test_who_waits_until_something_is_known_waits_on_and_until_works_meanwhile(run):
    assert run(f"wait_until: {UNKNOWN}").ticks(250) == 250 * "R"
    tree = run(f"until: [{UNKNOWN}, {{name: look, play: {{script: S}}}}]")
    assert tree.ticks(250) == 250 * "R"
    assert tree.begun("look") == 2


@pytest.mark.parametrize(
    "modifier",
    [
        "timeout_s: 9",
        "delay_s: 0.01",
        "invert: true",
        "retry: 9",
        "repeat: 9",
        "once: true",
        "cooldown_s: 9",
        "unless: {ask: {answers: F}}",
        "while: {ask: {answers: S}}",
        "force_success: true",
        "force_failure: true",
    ],
)
def test_every_modifier_passes_exceptions_and_halts_its_node_once(run, modifier):
    tree = run(f"{{name: a, {modifier}, play: {{script: RX}}}}")
    tree.ticks(2 if "delay" in modifier else 1)
    with pytest.raises(RuntimeError, match=r"^a broke$"):
        tree.ticks(1)
    tree.root.stop(Status.INVALID)
    tree.root.stop(Status.INVALID)
    assert tree.events == ["a begins", "a ends I"]


def test_all_modifiers_together_wrap_in_the_order_of_their_table(run):
    tree = run("""
force_failure: false
force_success: true
while: {ask: {answers: S}}
unless: {ask: {answers: F}}
cooldown_s: 1
once: true
repeat: 1
retry: 1
invert: true
delay_s: 1
timeout_s: 1
play: {script: S}
""")
    node, keys = tree.root, []
    while node.children:
        keys.append(node.key)
        node = node.children[-1]
    words = [key.removesuffix("_s") for key in MODIFIERS if key != "force_failure"]
    assert keys[::-1] == words
