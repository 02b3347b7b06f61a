"""Keys: what leaves write, who may read it, and what a reader is given."""

import pytest
from mistakes import found_in_toys, table
from tree_toys import Run

from behaviours import LeafCrashedError
from config import Severity


@pytest.fixture
def diagnostics(tmp_path):
    """See `found_in_toys`; the errors, if nothing else is said."""

    def found(tree: str, severity: Severity = Severity.ERROR) -> list[str]:
        return found_in_toys(tmp_path, tree, severity)

    return found


def test_the_value_is_that_at_the_start_of_the_reader(run):
    tree = run("repeat: 2\nsequence: [count: {times: n}, note: {value: $n}]")
    assert tree.ticks(4) == "RRRS"
    assert tree.events[::2] == ["note begins with 1.0", "note begins with 2.0"]


def test_set_writes_values_and_copies_keys(run):
    both = "{set: {n: 2.5, word: five}}, {set: {m: $n}}"
    tree = run(f"sequence: [{both}, note: {{value: $m}}, note: {{value: $word}}]")
    assert tree.ticks(1) == "R"
    assert tree.root.children[0].feedback_message == "n = 2.5, word = five"
    tree.ticks(3)
    assert tree.events[0] == "note begins with 2.5"
    assert tree.events[2] == "note begins with 'five'"


def test_a_reader_is_a_leaf_to_the_tree_and_is_halted_once(run):
    tree = run("sequence: [set: {n: 1}, {name: reader, note: {value: $n}}]")
    tree.ticks(1)
    reader = tree.root.children[1]
    assert (reader.name, reader.key, list(reader.children)) == ("reader", "note", [])
    assert reader.feedback_message == "noting 1.0"
    tree.root.stop()
    tree.root.stop()
    assert tree.events == ["reader begins with 1.0", "reader ends I"]


def test_a_value_that_the_leaf_refuses_is_a_failure_with_its_reason(run):
    tree = run("sequence: [set: {n: -1.0}, note: {value: $n}]")
    assert tree.ticks(1) == "F"
    assert tree.root.feedback_message == "note: refuses its parameters: the value is negative"


@pytest.mark.parametrize("reader", ["{name: r, note: {value: $n}}", "{name: r, set: {m: $n}}"])
def test_a_leaf_that_breaks_its_promise_to_write_is_named_by_whoever_reads(tmp_path, reader):
    tree = Run(tmp_path, f"sequence: [set: {{n: 1, m: 1}}, {reader}, note: {{value: $m}}]")
    tree.root.children[0] = tree.root.children[1]
    with pytest.raises(LeafCrashedError, match=r"^LookupError: .*nothing was written") as raised:
        tree.ticks(1)
    assert raised.value.leaf == "r"


@table("sure")
def test_a_key_that_is_certainly_written_may_be_read(diagnostics, row):
    assert diagnostics(row) == []


@table("unsure")
def test_a_key_that_may_not_be_written_is_a_mistake(diagnostics, row):
    [found] = diagnostics(row["task"])
    assert row["tells"] in found


def test_types_of_keys_are_checked_before_the_run(diagnostics):
    assert diagnostics("sequence: [set: {n: soon}, navigate: {to: $n}]") == [
        "1:43: expected a tool pose or a base pose, got `$n`, which is text"
    ]
    assert diagnostics("sequence: [set: {n: 1.5}, grasp: {within: $n, tries: $n}]") == [
        "1:43: expected a region, got `$n`, which is a number",
        "1:54: expected a whole number or null, got `$n`, which is a number",
    ]
    assert diagnostics("sequence: [set: {n: 1}, set: {n: one}, note: {value: $n}]") == [
        "1:31: `n` takes text here, and a whole number on line 3"
    ]


def test_an_output_is_a_plain_word_that_is_no_parameter(diagnostics):
    found = diagnostics(
        "sequence: [count: {times: $n}, count: {times: 3}, count: {times: }, count]"
    )
    assert [text.split(", and")[0] for text in found] == [
        "1:27: `times` names a key to write to",
        "1:47: `times` names a key to write to",
        "1:66: `times` names a key to write to",
        "1:69: `count` lacks `times` (a key for a whole number: how often [times])",
    ]


def test_a_key_that_nobody_reads_is_a_warning(diagnostics):
    assert diagnostics("sequence: [set: {n: 1}, count: {times: m}]", Severity.WARNING) == [
        "1:18: the key `n` is never read",
        "1:40: the key `m` is never read",
    ]
