"""Kinds of things: those that the shapes tell, and those that a package adds."""

from dataclasses import replace

import pytest
from harness import ON_TABLE, TABLE_TOP, Harness, block, table_world, with_the_hand_at
from pinocchio import SE3
from py_trees.common import Status
from tree_toys import check

from behaviours import Detect, DetectedObjects, Grasp, Key
from robots import Cylinder, Geom

APPLES = """
from frankie_task import Labelled

class Apples:
    kinds = ("apple", "pear")

    def recognise(self, frame, objects):
        left = min(objects, key=lambda one: one.box)
        wrong = Labelled(kind="pear", box=(0, 0, 9, 9), score=0.9)
        return [wrong, Labelled(kind="apple", box=left.box, score=0.6)]
"""
USES = """\
task: t
regions: {box: {centre: [0.7, 0, 0.5], size: [1, 1, 0.2]}}
tree: {grasp: {within: box, kind: KIND}}
"""


@pytest.fixture
def install_fruit(install):
    return lambda source: install(source, "recognisers", "fruit", "Apples")


@pytest.fixture
def task(tmp_path):
    def write(kind: str):
        (path := tmp_path / "t.yaml").write_text(USES.replace("KIND", kind))
        return path

    return write


def table() -> Harness:
    """A can and a block, the robot looking down at them; the can is left in the image."""
    parts = (Geom(Cylinder(0.02, 0.03), SE3.Identity(), "can", (60, 110, 190)),)
    can = replace(block((0.02, 0.02, 0.03), x=0.66, y=0.08, name="can"), parts=parts)
    other = block((0.018, 0.03, 0.02), x=0.66, y=-0.08, name="block")
    return with_the_hand_at(table_world(can, other), 0.6, 0.0, TABLE_TOP + 0.45)


def kinds_seen(harness: Harness, kind: str) -> list[str]:
    found = Key[DetectedObjects]("found")
    detect = Detect("see", harness.context, region=ON_TABLE, list=found, kind=kind)
    assert harness.run(detect) is Status.SUCCESS, detect.feedback_message
    return [one.kind for one in found.read()]


def test_the_hand_takes_the_kind_that_was_asked_for_and_nothing_else():
    harness = table()
    grasp = Grasp("grasp", harness.context, within=ON_TABLE, kind="ball", patience_s=0.5)
    assert harness.run(grasp) is Status.FAILURE
    assert "a ball is not among the 2 objects in sight" in grasp.feedback_message
    grasp = Grasp("grasp", harness.context, within=ON_TABLE, kind="can")
    assert harness.run(grasp) is Status.SUCCESS, grasp.feedback_message
    assert harness.world.held is harness.world.find("can")


def test_check_knows_the_kinds_of_recognisers(task, install_fruit):
    assert check(task("can")) == []
    (mistake,) = check(task("cann"))
    assert (mistake.location.line, mistake.location.column) == (3, 8)
    assert "asks for a `cann`, which no recogniser knows" in mistake.message
    assert mistake.hint == "did you mean `can`?"
    assert "which no recogniser knows" in str(check(task("apple"))[0])
    install_fruit(APPLES)
    assert check(task("apple")) == []
    assert check(task("aple"))[0].hint == "did you mean `apple`?"


def test_a_package_adds_a_kind(install_fruit):
    install_fruit(APPLES)
    assert kinds_seen(table(), "apple") == ["apple"]
    assert kinds_seen(table(), "pear") == []  # its box is on no object


BROKEN = {
    "raise ValueError('two\\nlines')": "ValueError: two lines",
    "class Apples:\n    kinds = (3,)\n": "its `kinds` are no words",
}


@pytest.mark.parametrize("source", BROKEN)
def test_a_broken_package_is_named_once_and_stops_only_who_asks_for_it(task, install_fruit, source):
    install_fruit(source)
    assert check(task("can")) == []
    (mistake,) = check(task("apple"))
    assert "recogniser `fruit` of `package_" in mistake.hint
    assert BROKEN[source] in mistake.hint
    assert "\n" not in str(mistake)


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("raise RuntimeError('no\\nweights')", "`fruit` failed: RuntimeError: no weights"),
        ("return ['apple']", "recogniser `fruit` failed: AttributeError"),
        ("return [Labelled(kind='apple', box=(0, 0, 1, 1), score=7)]", "a score from 0 to 1"),
    ],
)
def test_a_recogniser_that_fails_is_the_reason_of_the_leaf(install_fruit, body, told):
    head = "from frankie_task import Labelled\nclass Apples:\n    kinds = ['apple']\n"
    install_fruit(head + f"    def recognise(self, frame, objects):\n        {body}\n")
    harness = table()
    detect = Detect("see", harness.context, region=ON_TABLE, kind="apple")
    assert harness.run(detect) is Status.FAILURE
    assert told in detect.feedback_message
    assert "\n" not in detect.feedback_message
