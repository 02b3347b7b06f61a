"""Counting, cases, a node for each of several values, and rounds that go on where they stopped."""

from __future__ import annotations

import pytest
from mistakes import file_with, found_in, marked
from py_trees.common import Status
from tree_toys import TOYS, ToyContext

from config import Severity
from trees.language import build, load

BOXES = "regions: {left: {centre: [0, 1, 1], size: [1, 1, 1]}, right: {centre: [0, 2, 1], size: "
BOXES += "[1, 1, 1]}}\n"


@pytest.fixture
def toy(tmp_path):
    """A tree of toys and what they note."""

    def make(tree: str, sections: str = "", **overrides: str):
        path = tmp_path / "t.yaml"
        path.write_text(f"task: toy\n{sections}tree:\n  {tree}\n")
        context = ToyContext()
        return build(load(path, leaves=TOYS, overrides=overrides), context), context

    return make


def test_for_each_runs_a_node_for_each_value_in_order(toy):
    note = "for_each: {item: place, in: [left, right], do: {grasp: {within: $place}}}"
    root, _ = toy(note, BOXES)
    root.tick_once()
    assert root.status is Status.SUCCESS
    assert [child.name for child in root.children] == ["grasp left", "grasp right"]
    assert [child.within.name for child in root.children] == ["left", "right"]


@pytest.mark.parametrize(("side", "chosen"), [("left", "a"), ("right", "b")])
def test_switch_runs_the_case_of_its_value(toy, side, chosen):
    cases = "{left: {name: a, play: {script: S}}, right: {name: b, play: {script: S}}}"
    tree = f"switch: {{value: $side, cases: {cases}}}"
    root, context = toy(tree, "params: {side: {type: [left, right]}}\n", side=side)
    root.tick_once()
    assert root.status is Status.SUCCESS
    assert context.events == [f"{chosen} begins", f"{chosen} ends S"]


@pytest.mark.parametrize(
    ("value", "status"),
    [("2", "S"), ("2.0", "S"), ("3", "F"), ("'2'", "S"), ("true", "R"), ("1", "F")],
)
def test_switch_compares_numbers_texts_and_truth_values(toy, value, status):
    kind = "true" if value == "true" else "2"
    cases = f"{{'{kind}': {{play: {{script: {'R' if value == 'true' else 'S'}}}}}}}"
    root, _ = toy(f"sequence: [set: {{k: {value}}}, switch: {{value: $k, cases: {cases}}}]")
    root.tick_once()
    assert root.status.value[0] == status


def test_a_resuming_sequence_goes_on_where_a_guard_has_halted_it(toy):
    steps = (
        "{name: a, play: {script: S}}, {name: b, play: {script: RS}}, {name: c, play: {script: S}}"
    )
    root, context = toy(
        f"forever: {{while: {{ask: {{answers: SFSS}}}}, resuming_sequence: [{steps}]}}"
    )
    for _ in range(3):
        root.tick_once()
    assert root.status is Status.SUCCESS
    begun = [event for event in context.events if event.endswith("begins")]
    assert begun == ["a begins", "b begins", "b begins", "c begins"]


def test_a_resuming_sequence_tries_a_failed_child_again_and_then_begins_anew(toy):
    steps = "{name: a, play: {script: S}}, {name: b, play: {script: FS}}"
    root, context = toy(f"retry: 2\n  resuming_sequence: [{steps}]")
    root.tick_once()
    root.tick_once()
    assert root.status is Status.SUCCESS
    begun = [event for event in context.events if event.endswith("begins")]
    assert begun == ["a begins", "b begins", "b begins"]
    root.tick_once()
    assert context.events[-4] == "a begins"


ERRORS = (
    ("¦add: {}", "`add` names no key"),
    ("¦add:", "`add` names no key; write `add: {key: value}`"),
    ("add: {¦tries: 1}", "`$tries` is neither a parameter nor a key that is written before"),
    ("sequence: [set: {k: six}, add: {¦k: 1}]", "expected a whole number or a number, got `$k`"),
    ("sequence: [set: {k: 0}, add: {¦k: 0.5}]", "begin with `set: {k: 0.0}`"),
    ("sequence: [set: {k: 0}, add: {k: ¦more}]", "`add` cannot add the text `more`"),
    ("add: {¦count: 1}", "`count` is a parameter, and cannot be written to"),
    ("for_each: ¦[box, table]", "`for_each` is a mapping, not a list"),
    ("for_each: ¦{item: x, in: [box]}", "`for_each` lacks `do`"),
    ("for_each: {item: x, in: ¦box, do: open_gripper}", "`in` is a list of 1 to 100"),
    ("for_each: {item: x, in: ¦[], do: open_gripper}", "`in` has 0 values"),
    ("for_each: {item: ¦count, in: [box], do: open_gripper}", "`count` is a parameter"),
    ("for_each: {item: ¦2, in: [box], do: open_gripper}", "`item` names a key"),
    ("for_each: {item: x, in: [box, ¦tabel], do: {grasp: {within: $x}}}", "did you mean `table`?"),
    ("for_each: {item: x, in: [¦$k], do: {grasp: {within: $x}}}", "known before the run"),
    ("for_each: {item: x, in: [box, ¦3], do: {grasp: {within: $x}}}", "of several kinds"),
    ("for_each: {item: x, in: [folded], do: {grasp: {within: ¦$x}}}", "the posture `folded`"),
    ("for_each: {item: x, in: [box], do: {grasp: {¦withn: $x, within: $x}}}", "`withn`"),
    ("for_each: {item: x, ¦on: [box], in: [box], do: open_gripper}", "has no key `on`"),
    ("switch: ¦[open_gripper]", "`switch` is a mapping"),
    ("switch: ¦{value: $count}", "`switch` lacks `cases`"),
    ("switch: {value: $count, cases: ¦[open_gripper]}", "`cases` is a mapping"),
    ("switch: {value: $count, cases: ¦{}}", "values to nodes, not empty"),
    ("switch: {value: $count, cases: {¦3: open_gripper}}", "write it in quotes"),
    ("¦switch: {value: $count, cases: {three: open_gripper}}", "the case `three` is none"),
    ("switch: {value: ¦$k, cases: {a: open_gripper}}", "`$k` is neither a parameter nor a key"),
    ("switch: {value: $word, cases: {a: ¦[open_gripper]}}", "expected a node, got a list"),
    ("switch: {value: $word, cases: {a: open_gripper}, ¦default: recover}", "no key `default`"),
    ("¦resuming_sequence: []", "is empty"),
)


@pytest.mark.parametrize(("item", "why"), ERRORS, ids=[item for item, _ in ERRORS])
def test_what_cannot_be_meant_is_refused(tmp_path, item, why):
    text = file_with(item=f"- {item}")
    found = found_in(tmp_path, text)
    assert (found[0].location.line, found[0].location.column) == marked(text)
    assert why in str(found[0])
    assert found[0].hint


def test_a_case_that_its_parameter_never_has_is_refused(tmp_path):
    text = file_with(item="- switch: {value: $side, cases: {¦lfet: open_gripper}}")
    text = text.replace("params:\n", "params:\n  side: {type: [left, right], default: left}\n")
    [found] = found_in(tmp_path, text)
    assert (found.location.line, found.location.column) == marked(text)
    assert str(found).endswith("`$side` is never `lfet`; did you mean `left`?")


def test_an_item_that_is_not_used_is_warned_of(tmp_path):
    text = file_with(item="- for_each: {item: ¦x, in: [box], do: open_gripper}")
    [found] = found_in(tmp_path, text, Severity.WARNING)
    assert (found.location.line, found.location.column) == marked(text)
    assert "the item `x` is never used" in str(found)


def test_values_within_values_are_bounded(tmp_path):
    numbers = ", ".join(str(number) for number in range(100))
    inner = f"for_each: {{item: b, in: [{numbers}], do: {{wait: {{duration_s: $b}}}}}}"
    text = file_with(item=f"- ¦for_each: {{item: a, in: [{numbers}], do: {{{inner}}}}}")
    found = found_in(tmp_path, text)
    assert "more than 1000 nodes" in str(found[0])
