"""What starts again after a failure: when, how often, and when it gives up."""

from py_trees.common import Status

from behaviours import Carried
from hw import TaskTime
from trees.language import failed_node


def test_forever_gives_up_when_it_always_fails_alike(run):
    tree = run("forever: {name: b, delay_s: 3, play: {script: F}}")
    assert tree.to_the_end() == "F"
    assert tree.begun("b") == 5
    assert tree.root.feedback_message == "gave up: b: said F, 5 times in a row"
    assert failed_node(tree.root).feedback_message == "said F, 5 times in a row"


def test_forever_goes_on_as_long_as_objects_are_placed(run):
    tree = run("forever: {name: b, delay_s: 3, play: {script: FFFFFFFFS}}")
    for _ in range(9 * 301):
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
