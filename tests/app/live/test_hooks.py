"""Breakpoints and replaced nodes in a running session."""

import pytest
from controlled_run import ControlledRun, leaf
from py_trees.common import Status

from app.core.outcome import End
from app.live.operator import HookAction, Side, UnknownNodeError, matching
from trees.words.composites import Fallback, Sequence
from trees.words.modifiers import Retry


def two_leaves(context):
    first, second = leaf("first", 20)(context), leaf("second", 20)(context)
    return Sequence("sequence", [first, second])


def test_a_breakpoint_pauses_before_the_node_does_anything():
    run = ControlledRun(two_leaves, hooked=["second"])
    run.hooks[0].actions = {Side.BEFORE: HookAction()}
    second = run.nodes[2].node
    begun = []
    run._at = {40: lambda: (begun.append(second.begun), run.control.resume())}
    assert run.run().end is End.SUCCESS
    assert begun == [0]
    assert second.begun == 1
    assert len(second.updates) == 20
    assert run.reached == [("second", Side.BEFORE)]


def test_a_breakpoint_holds_every_time_the_node_is_entered_or_once():
    def root(context):
        return Retry(leaf("flaky", 3, Status.FAILURE)(context), 3, context.clock.now)

    for once, times in ((False, 3), (True, 1)):
        run = ControlledRun(root, hooked=["flaky"])
        run.hooks[0].actions = {Side.BEFORE: HookAction(once=once)}
        run._at = dict.fromkeys(range(10, 60, 10), run.control.resume)
        assert run.run().end is End.FAILURE
        assert len(run.reached) == times


def test_a_node_can_be_replaced_and_the_tree_believes_it():
    def root(context):
        return Fallback("fallback", [leaf("doomed", 3)(context), leaf("rescue", 3)(context)])

    run = ControlledRun(root, hooked=["doomed"])
    run.hooks[0].actions = {Side.BEFORE: HookAction(replace_with=Status.FAILURE)}
    assert run.run().end is End.SUCCESS
    assert run.nodes[1].node.begun == 0
    assert run.nodes[2].node.begun == 1


def test_a_person_may_choose_the_outcome_after_a_node_has_ended():
    run = ControlledRun(two_leaves, hooked=["first"])
    run.hooks[0].actions = {Side.AFTER: HookAction()}

    def choose() -> None:
        run.hooks[0].answer = Status.FAILURE
        run.control.resume()

    run._at = {40: choose}
    outcome = run.run()
    assert outcome.end is End.FAILURE
    assert outcome.node == "first"
    assert outcome.reason == "failure chosen by a person"
    assert len(run.nodes[1].node.updates) == 20
    assert run.nodes[2].node.begun == 0


def test_hooks_that_do_nothing_change_nothing():
    def root(context):
        inner = Sequence("inner", [leaf("a", 3)(context), leaf("b", 3, Status.FAILURE)(context)])
        return Retry(inner, 2, context.clock.now)

    plain, hooked = ControlledRun(root), ControlledRun(root, hooked=["retry", "inner", "a", "b"])
    outcomes = [plain.run(), hooked.run()]
    assert outcomes[0] == outcomes[1]
    assert plain.root.feedback_message == hooked.root.feedback_message
    assert plain.commands.tobytes() == hooked.commands.tobytes()
    assert len(plain.ticks) == len(hooked.ticks)


def test_nodes_are_found_by_name_key_and_path():
    nodes = ControlledRun(two_leaves).nodes
    assert [n.name for n in matching(nodes, "second")] == ["second"]
    assert [n.name for n in matching(nodes, "going")] == ["first", "second"]
    assert [n.name for n in matching(nodes, "sequence/first")] == ["first"]
    with pytest.raises(UnknownNodeError, match="did you mean `second`"):
        matching(nodes, "secund")
