"""Breakpoints and chosen outcomes in a running session."""

import pytest
from controlled_run import ControlledRun, leaf
from py_trees.common import Status

from app.core.outcome import End
from app.live.operator import UnknownNodeError, matching
from trees.words.composites import Sequence
from trees.words.modifiers import Retry


def two_leaves(context):
    first, second = leaf("first", 20)(context), leaf("second", 20)(context)
    return Sequence("sequence", [first, second])


def test_a_breakpoint_pauses_before_the_node_does_anything():
    run = ControlledRun(two_leaves, hooked=["second"])
    run.hooks[0].stops = True
    second = run.nodes[2].node
    begun = []
    run._at = {40: lambda: (begun.append(second.begun), run.control.resume())}
    assert run.run().end is End.SUCCESS
    assert begun == [0]
    assert second.begun == 1
    assert len(second.updates) == 20
    assert run.reached == ["second"]


def test_a_breakpoint_holds_every_time_the_node_is_entered():
    def root(context):
        return Retry(leaf("flaky", 3, Status.FAILURE)(context), 3, context.clock.now)

    run = ControlledRun(root, hooked=["flaky"])
    run.hooks[0].stops = True
    run._at = dict.fromkeys(range(10, 60, 10), run.control.resume)
    assert run.run().end is End.FAILURE
    assert len(run.reached) == 3


def test_hooks_that_do_nothing_change_nothing():
    def root(context):
        inner = Sequence("inner", [leaf("a", 3)(context), leaf("b", 3, Status.FAILURE)(context)])
        return Retry(inner, 2, context.clock.now)

    plain, hooked = ControlledRun(root), ControlledRun(root, hooked=["retry", "inner", "a", "b"])
    outcomes = [plain.run(), hooked.run()]
    assert outcomes[0] == outcomes[1]
    assert plain.root.feedback_message == hooked.root.feedback_message
    assert plain.commands.tobytes() == hooked.commands.tobytes()


def test_nodes_are_found_by_name_key_and_path():
    nodes = ControlledRun(two_leaves).nodes
    assert [n.name for n in matching(nodes, "second")] == ["second"]
    assert [n.name for n in matching(nodes, "going")] == ["first", "second"]
    assert [n.name for n in matching(nodes, "sequence/first")] == ["first"]
    with pytest.raises(UnknownNodeError, match="did you mean `second`"):
        matching(nodes, "secund")
