"""Cases, a node for each of several values or objects, and comparisons."""

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from tree_toys import LETTER, TOYS, ToyContext

from behaviours import DetectedObjects, Key
from trees.language import build, load

BOX = "{centre: [0, 1, 1], size: [1, 1, 1]}"


@pytest.fixture
def toy(tmp_path):
    """A tree of toys and what they note."""

    def make(tree: str, sections: str = "", leaves=TOYS, **overrides: str):
        path = tmp_path / "t.yaml"
        path.write_text(f"task: toy\n{sections}tree:\n  {tree}\n")
        context = ToyContext()
        return build(load(path, leaves=leaves, overrides=overrides), context), context

    return make


def test_for_each_runs_a_node_for_each_value_in_order(toy):
    note = "for_each: {item: place, in: [left, right], do: {grasp: {within: $place}}}"
    root, _ = toy(note, f"regions: {{left: {BOX}, right: {BOX}}}\n")
    root.tick_once()
    assert root.status is Status.SUCCESS
    assert [child.name for child in root.children] == ["grasp left", "grasp right"]
    assert [child.within.name for child in root.children] == ["left", "right"]


@pytest.mark.parametrize("side", ["left", "right"])
def test_switch_runs_the_case_of_its_value(toy, side):
    cases = "{left: {name: left, play: {script: S}}, right: {name: right, play: {script: S}}}"
    tree = f"switch: {{value: $side, cases: {cases}}}"
    root, context = toy(tree, "params: {side: {type: [left, right]}}\n", side=side)
    root.tick_once()
    assert context.events == [f"{side} begins", f"{side} ends S"]


@pytest.mark.parametrize(
    ("question", "status"),
    [
        ("compare: {value: $left, equals: left}", "S"),
        ("compare: {value: $left, equals: right}", "F"),
        ("compare: {value: $three, equals: 3.0}", "S"),
        ("compare: {value: $three, least: 2.5}", "S"),
        ("compare: {value: $three, least: 3.5}", "F"),
    ],
)
def test_values_are_compared(toy, question, status):
    root, _ = toy(f"sequence: [set: {{left: left, three: 3}}, {question}]", leaves=None)
    root.tick_once()
    assert LETTER[root.status] == status


class Noted(Behaviour):
    """Notes what it is given."""

    def __init__(self, name: str, outcomes: list[Status], seen: list[object], arguments) -> None:
        super().__init__(name)
        self.outcomes, self.seen, self.arguments = outcomes, seen, arguments

    def update(self) -> Status:
        for value in self.arguments.values():
            if isinstance(value, Key):
                value.write(DetectedObjects(self.seen))
        return self.outcomes.pop(0) if self.outcomes else Status.SUCCESS


EACH = """\
task: t
regions: {box: {centre: [0.7, 0, 0.5], size: [1, 1, 0.2]}}
tree:
  sequence:
    - detect: {region: box, list: things}
    - for_each: {item: o, in: $things, do: {look_at: {at: $o}}}
"""
R, S, F = Status.RUNNING, Status.SUCCESS, Status.FAILURE


@pytest.mark.parametrize(
    ("found", "outcomes", "seen", "end"),
    [
        (["a", "b", "c"], [], ["a", "b", "c"], S),
        ([], [], [], S),
        (["a", "b", "c"], [S, F], ["a", "b"], F),
        (["a", "b"], [R, R, S], ["a", "b"], S),
    ],
    ids=["each in order", "an empty list", "a failure ends it", "one takes time"],
)
def test_a_node_runs_once_for_each_object_that_was_seen(tmp_path, found, outcomes, seen, end):
    path = tmp_path / "t.yaml"
    path.write_text(EACH)
    given: list[object] = []

    def leaf(node, context, arguments):
        if node.name == "detect":
            return Noted(node.name, [], found, arguments)
        given.append(arguments["at"])
        return Noted(node.name, outcomes, [], arguments)

    root = build(load(path), ToyContext(), leaf)
    while root.status in (Status.INVALID, Status.RUNNING):
        root.tick_once()
    assert (given, root.status) == (seen, end)
