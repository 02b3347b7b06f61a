"""Keys: what leaves write, who may read it, and what a reader is given."""

import pytest
from mistakes import table
from tree_toys import TOYS, Run

from behaviours import Key, LeafCrashedError
from config import Severity
from trees.language import check


@pytest.fixture
def diagnostics(tmp_path):
    """The errors of a tree section, as `line:column: message` counted from its first line."""

    def found(tree: str, severity: Severity = Severity.ERROR) -> list[str]:
        path = tmp_path / "t.yaml"
        lines = "\n".join(f"  {line}" for line in tree.strip().splitlines())
        path.write_text(f"task: toy\ntree:\n{lines}\n")
        return [
            f"{diagnostic.location.line - 2}:{diagnostic.location.column - 2}: {diagnostic.message}"
            for diagnostic in check(path, leaves=TOYS)
            if diagnostic.severity is severity
        ]

    return found


def test_the_value_is_that_at_the_start_of_the_reader(run):
    tree = run("repeat: 2\nsequence: [count: {times: n}, note: {value: $n}]")
    assert tree.ticks(4) == "RRRS"
    assert [event for event in tree.events if "begins" in event] == [
        "note begins with 1.0",
        "note begins with 2.0",
    ]


def test_set_writes_values_and_copies_keys(run):
    tree = run("""
sequence:
  - set: {n: 2.5, word: five}
  - set: {m: $n}
  - note: {value: $m}
  - note: {value: $word}
""")
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


def test_a_leaf_that_breaks_its_promise_to_write_is_named(tmp_path):
    key = Key("n")
    with pytest.raises(LookupError, match=r"nothing was written to the key `n`"):
        key.read()
    key.write(3)
    assert key.read() == 3
    tree = Run(tmp_path, "sequence: [set: {n: 1}, note: {value: $n}]")
    tree.root.children[0] = tree.root.children[1]
    with pytest.raises(LeafCrashedError, match=r"^LookupError: .*nothing was written"):
        tree.ticks(1)


def test_set_that_copies_what_is_not_there_is_named(tmp_path):
    tree = Run(tmp_path, "sequence: [set: {n: 1}, {name: copy, set: {m: $n}}, note: {value: $m}]")
    tree.root.children[0] = tree.root.children[1]
    with pytest.raises(LeafCrashedError) as raised:
        tree.ticks(1)
    assert raised.value.leaf == "copy"


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
