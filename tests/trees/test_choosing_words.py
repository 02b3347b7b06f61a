"""Words for what was seen: what `check` says about them, and what they do."""

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from tree_toys import ToyContext

from behaviours import DetectedObjects, Key
from trees.language import build, check, load

HEAD = """\
task: t
regions: {box: {centre: [0.7, 0, 0.5], size: [1, 1, 0.2]}}
tree:
  sequence:
"""
LIST = "    - detect: {region: box, list: things}\n"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("    - grasp: {within: box, choose: bigest}\n", "; did you mean `best`?"),
        ("    - grasp: {within: box, choose: biggest}\n", "; did you mean `largest`?"),
        ("    - grasp: {within: box, colour: Violet}\n", "; did you mean `purple`?"),
        ("    - pick_up: {within: box}\n", "unknown node `pick_up`; write `grasp`, then"),
        ("    - grasp: {within: box, colour: reed}\n", "; did you mean `red`?"),
        (
            "    - grasp: {within: box, min_width_mm: 60, max_width_mm: 20}\n",
            "a least width of 60 mm and a largest of 20 mm, between which nothing is; exchange",
        ),
        ("    - grasp: {within: box, min_width_mm: 0.04}\n", "; did you mean 40 (from metres)?"),
        (LIST + "    - grasp: {within: $things}\n", "`$things`, which is a list of detected obj"),
        (
            LIST + "    - for_each: {item: o, in: $things, do: {grasp: {within: $o, choose: "
            "largest}}}\n",
            "chooses by `choose` among one object, that of `within`; leave it out",
        ),
        (
            LIST + "    - for_each: {item: o, in: $things, do: {grasp: {within: $o, neighbour: "
            "true}}}\n",
            "chooses by `neighbour` among one object, that of `within`; leave it out",
        ),
        (
            "    - grasp: {within: box, neighbour: true, choose: best}\n",
            "`grasp` takes a neighbour, and nothing says of which object; add `choose: largest`",
        ),
        (
            LIST + "    - for_each: {item: o, in: $things, do: {place: {on: $o}}}\n",
            "expected a region, got `$o`, which is a detected object",
        ),
        (
            LIST + "    - for_each: {item: o, in: things, do: {look_at: {at: $o}}}\n",
            "not the text `things`; write `$things` if that is its key",
        ),
        (
            "    - set: {n: 3}\n    - for_each: {item: o, in: $n, do: {look_at: {at: $o}}}\n",
            "expected a list of detected objects, got `$n`, which is a whole number",
        ),
        (
            "    - for_each: {item: o, in: $none, do: {look_at: {at: $o}}}\n",
            "`$none` is neither a parameter nor a key that is written before",
        ),
        (
            LIST + "    - for_each: {item: o, in: $things, do: {look_at: {at: $o}}}\n"
            "    - grasp: {within: $o}\n",
            "`$o` is not written on every way here",
        ),
        (
            LIST + "    - for_each: {item: o, in: $things, do: {looks_like: {object: $o}}}\n",
            "`looks_like` asks nothing of its object; add `colour`",
        ),
        (
            "    - looks_like: {object: box, colour: red}\n",
            "expected a detected object, got the text `box`; give `$` and the key of a `detect`",
        ),
        (LIST + "    - add: {things: 1}\n", "got `$things`, which is a list of detected objects"),
    ],
)
def test_a_mistake_has_its_place_and_its_hint(tmp_path, body, message):
    path = tmp_path / "t.yaml"
    path.write_text(HEAD + body)
    errors = [str(one) for one in check(path) if "warning" not in str(one)]
    assert len(errors) == 1, errors
    assert message in errors[0]


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


EACH = HEAD + LIST + "    - for_each: {item: o, in: $things, do: {look_at: {at: $o}}}\n"


def ticks(tmp_path, found: list[object], outcomes: list[Status]) -> tuple[list[object], Status]:
    """What `look_at` was given in which order, and how the tree ended."""
    path = tmp_path / "t.yaml"
    path.write_text(EACH)
    given: list[object] = []

    def leaf(node, context, arguments):
        if node.name == "detect":
            return Noted(node.name, [], found, arguments)
        given.append(arguments["at"])
        return Noted(node.name, outcomes, [], arguments)

    root = build(load(path), ToyContext(), leaf)
    for _ in range(10):
        root.tick_once()
        if root.status is not Status.RUNNING:
            break
    return given, root.status


def test_a_node_runs_once_for_each_object_in_order(tmp_path):
    assert ticks(tmp_path, ["a", "b", "c"], []) == (["a", "b", "c"], Status.SUCCESS)


def test_nothing_on_the_list_is_a_success(tmp_path):
    assert ticks(tmp_path, [], []) == ([], Status.SUCCESS)


def test_the_first_failure_ends_it(tmp_path):
    outcomes = [Status.SUCCESS, Status.FAILURE]
    assert ticks(tmp_path, ["a", "b", "c"], outcomes) == (["a", "b"], Status.FAILURE)


def test_an_object_goes_on_while_it_takes_time(tmp_path):
    outcomes = [Status.RUNNING, Status.RUNNING, Status.SUCCESS]
    assert ticks(tmp_path, ["a", "b"], outcomes) == (["a", "b"], Status.SUCCESS)
