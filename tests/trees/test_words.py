"""What composites and modifiers do, tick by tick, in simulated time; `ticks.yaml` has tables."""

from pathlib import Path

import pytest
import yaml
from py_trees.common import Status

from behaviours import Carried
from hw import TaskTime
from trees.language import MODIFIERS, failed_node

TABLES = yaml.safe_load((Path(__file__).parent / "ticks.yaml").read_text("utf-8"))


@pytest.mark.parametrize("row", TABLES["ticks"], ids=lambda row: row["what"])
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
    tree = run("{retry: 3, parallel: [{name: a, play: {script: R}}, {name: b, play: {script: X}}]}")
    with pytest.raises(RuntimeError, match=r"^b broke$"):
        tree.ticks(1)
    tree.root.stop(Status.INVALID)
    assert tree.events == ["a begins", "b begins", "a ends I"]


UNKNOWN = "{name: q, ask: {answers: R}}"


@pytest.mark.parametrize("asks", TABLES["not_known"])
def test_what_stays_not_known_fails_whoever_asks_and_nothing_below_it_runs(run, asks):
    tree = run(asks.replace("Q", UNKNOWN))
    assert tree.ticks(100) == 100 * "R"
    assert tree.ticks(1) == "F"
    assert tree.events == []
    assert failed_node(tree.root).name == "q"


def test_who_waits_until_something_is_known_waits_on_and_until_works_meanwhile(run):
    assert run(f"until: {UNKNOWN}").ticks(250) == 250 * "R"
    tree = run(f"until: [{UNKNOWN}, {{name: look, play: {{script: S}}}}]")
    assert tree.ticks(250) == 250 * "R"
    assert tree.begun("look") == 2


@pytest.mark.parametrize("modifier", TABLES["modifiers"])
def test_every_modifier_passes_exceptions_and_halts_its_node_once(run, modifier):
    tree = run(f"{{name: a, {modifier}, play: {{script: RX}}}}")
    tree.ticks(1)
    with pytest.raises(RuntimeError, match=r"^a broke$"):
        tree.ticks(1)
    tree.root.stop(Status.INVALID)
    tree.root.stop(Status.INVALID)
    assert tree.events == ["a begins", "a ends I"]


def test_all_modifiers_together_wrap_in_the_order_of_their_table(run):
    *most, _ = TABLES["modifiers"]  # of `force` one value
    modifiers = ", ".join(reversed(most))
    node, keys = run(f"{{{modifiers}, play: {{script: S}}}}").root, []
    while node.children:
        keys.append(node.key)
        node = node.children[-1]
    words = [key.removesuffix("_s").replace("force", "force_success") for key in MODIFIERS]
    assert keys[::-1] == words


def test_forever_gives_up_when_it_always_fails_alike(run):
    tree = run("forever: {sequence: [wait: {duration_s: 3}, {name: b, play: {script: F}}]}")
    assert tree.to_the_end() == "F"
    assert tree.begun("b") == 5
    assert tree.root.feedback_message == "gave up: b: said F, 5 times in a row"
    assert failed_node(tree.root).feedback_message == "said F, 5 times in a row"


def test_forever_goes_on_as_long_as_objects_are_placed(run):
    tree = run("forever: {sequence: [wait: {duration_s: 3}, {name: b, play: {script: FFFFFFFFS}}]}")
    for _ in range(9 * 302):
        tree.context.log.carried = [Carried(begun=TaskTime(0.0), placed=TaskTime(1.0))] * (
            tree.begun("b") // 4
        )
        if tree.ticks(1) != "R":
            break
    assert tree.root.status is Status.SUCCESS


def test_forever_may_wait_for_a_condition(run):
    assert set(run("forever: {name: b, ask: {answers: F}}").ticks(3000)) == {"R"}


def test_what_fails_at_once_for_ever_is_tried_a_few_times_until_it_is_given_up(run):
    tree = run("forever: {retry: 5, name: b, play: {script: F}}")
    assert tree.to_the_end() == "F"
    assert tree.begun("b") <= 25


def test_what_cannot_be_reached_is_tried_twice(run):
    tree = run("forever: {retry: 5, name: b, play: {script: FFFFFFFFFFFFS}}")
    next(node for node in tree.root.iterate() if node.name == "b").out_of_reach = True
    assert tree.to_the_end() == "F"
    assert tree.begun("b") == 2
