"""Pausing, stepping and stopping a session, faults, breakpoints."""

import os
import pty
import termios
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest
from controlled_run import ControlledRun, leaf, two_leaves
from harness import BUTTON
from py_trees.common import Status
from waiting import until

from app.core.outcome import End
from app.live.control import Control
from app.live.hooks import UnknownNodeError, matching
from app.live.operator_console import keys
from hw import Fault, FaultKind
from trees.words.composites import Sequence
from trees.words.modifiers import Retry, Timeout


def test_a_pause_rests_smoothly_counts_in_no_timeout_and_the_robot_goes_on_where_it_was():
    run = ControlledRun(lambda context: Timeout(leaf(ticks=200)(context), 2.5, context.clock.now))
    run._at = {100: run.control.pause, 250: run.control.resume}
    assert run.run().end is End.SUCCESS  # 2 s of its own, 1.5 s paused
    assert run.speed_after(99) > 0.3
    assert run.speed_after(249) < 1e-3
    assert run.speed_after(340) > 0.3
    run.assert_kept_limits()
    going = run.nodes[-1].node
    assert going.begun == 1  # not started again
    assert len(going.updates) == 200
    np.testing.assert_allclose(np.diff([one.seconds for one in going.updates]), 0.01, atol=1e-9)
    assert all((tick.goal is None) is tick.paused for tick in run.ticks[:340])
    assert [tick.paused for tick in run.ticks].count(True) == 150
    assert run.ticks[-1].state.stamp > 3.4  # the session's time went on


def test_a_step_is_one_tick_of_the_tree_and_steps_add_up():
    run, counts = ControlledRun(leaf(ticks=30)), []

    def count_and(*actions) -> None:
        counts.append(run.control.state.ticks)
        for action in actions:
            action()

    run._at = {
        10: run.control.pause,
        20: lambda: count_and(run.control.step, run.control.step),
        40: lambda: count_and(run.control.resume),
    }
    assert run.run().end is End.SUCCESS
    assert counts == [10, 12]
    paused = [tick.paused for tick in run.ticks[:24]]
    assert paused == [False] * 10 + [True] * 10 + [False] * 2 + [True] * 2


def test_the_next_change_of_a_node_pauses_the_run():
    run = ControlledRun(two_leaves)
    statuses = []

    def watch_changes(tick) -> None:
        now = [place.node.status for place in run.nodes]
        if statuses and now != statuses[-1]:
            run.control.node_changed()
        statuses.append(now)
        ControlledRun._watch(run, tick)

    run._watch = watch_changes
    run._at = {5: run.control.run_to_next_change, 30: run.control.resume}
    assert run.run().end is End.SUCCESS
    # In tick 19 the first ended and the second began.
    assert [tick.number for tick in run.ticks if tick.paused] == [*range(20, 30)]


@pytest.mark.parametrize("paused", [False, True])
def test_a_stop_halts_the_tree_and_ends_the_run_as_interrupted(paused):
    run = ControlledRun(leaf(ticks=1000))
    run._at = {100: run.control.pause} if paused else {}
    run._at[200] = run.control.stop
    outcome = run.run()
    assert (outcome.end, outcome.end.exit_code) == (End.INTERRUPTED, 130)
    assert run.nodes[0].node.halted == 1
    run.assert_came_smoothly_to_rest(emergency=True)


@pytest.mark.realtime
def test_the_control_may_be_told_from_another_thread():
    """Also without a pace: a paused simulation waits in real time and does not race ahead."""
    run = ControlledRun(leaf(ticks=100_000))

    def person() -> None:
        for action in (run.control.pause, run.control.step, run.control.resume):
            time.sleep(0.05)
            action()
        time.sleep(0.1)
        run.control.pause()
        time.sleep(0.5)
        paused.append(sum(tick.paused for tick in run.ticks))
        run.control.stop()

    paused: list[int] = []
    thread = threading.Thread(target=person)
    thread.start()
    assert run.run().end is End.INTERRUPTED
    thread.join()
    assert 5 <= paused[0] <= 70  # of 100 a second at most


LOST = Fault(kind=FaultKind.STALE_POSE, text="the pose of the base is old", clearable=False)


def faulty(ticks: int = 400) -> tuple[ControlledRun, Callable[..., None]]:
    """A run, and what gives its robot just these faults."""
    run = ControlledRun(leaf(ticks=ticks))
    return run, lambda *faults: setattr(run.harness.robot, "faults", faults)


def test_what_only_a_person_may_clear_pauses_the_run_until_a_person_resumes_it():
    run, has = faulty()
    run._at = {100: lambda: has(LOST), 250: has, 350: run.control.resume}
    assert run.run().end is End.SUCCESS
    assert run.speed_after(249) < 1e-3
    assert [tick.paused for tick in run.ticks].count(True) == 250
    assert run.speed_after(349) < 1e-3
    assert run.speed_after(450) > 0.3


def test_a_released_emergency_stop_waits_for_a_person_who_acknowledges_and_then_resumes():
    run, has = faulty()
    whys = []

    def note(act) -> None:
        act()
        whys.append(run.control.state.why)

    run._at = {
        100: lambda: has(BUTTON),
        150: lambda: note(run.control.acknowledge),  # still pressed
        160: run.control.resume,
        200: has,
        250: lambda: note(run.control.resume),  # not yet acknowledged
        260: run.control.step,
        270: run.control.run_to_next_change,
        300: run.control.acknowledge,
        350: lambda: note(lambda: None),  # which only permits to resume
        400: run.control.resume,
    }
    assert run.run().end is End.SUCCESS
    assert run.speed_after(99) > 0.3
    assert max(run.speed_after(k) for k in range(200, 400)) < 1e-3
    assert run.speed_after(480) > 0.3
    assert whys == [
        "emergency stop pressed",
        "emergency stop: released, not yet acknowledged",
        "emergency stop acknowledged",
    ]
    run.assert_kept_limits(emergency=True)


def test_an_emergency_stop_that_nobody_can_acknowledge_ends_the_run_in_six_tenths_of_a_second():
    run, has = faulty(ticks=1000)
    run.control.attended = False
    run._at = {180: lambda: has(BUTTON)}
    outcome = run.run()
    assert outcome.end is End.HARDWARE
    assert outcome.reason == "emergency stop pressed; nobody is here to acknowledge it"
    speeds = [abs(tick.state.base_twist[0]) for tick in run.ticks[180:]]
    assert speeds[0] > 0.99
    assert next(k for k, speed in enumerate(speeds) if speed < 0.01) <= 60
    assert run.speed_after(-1) < 1e-3


def test_a_breakpoint_pauses_each_time_before_the_node_does_anything():
    def root(context):
        return Retry(leaf("flaky", 3, Status.FAILURE)(context), 3, context.clock.now)

    run, begun = ControlledRun(root, hooked=["flaky"]), []
    run.hooks[0].stops = True
    flaky = run.nodes[-1].node

    def go_on() -> None:
        begun.append(flaky.begun)
        run.control.resume()

    run._at = dict.fromkeys((10, 30, 50), go_on)
    assert run.run().end is End.FAILURE
    assert (begun, flaky.begun) == ([0, 1, 2], 3)
    assert run.reached == ["flaky"] * 3


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


def test_keys_pause_step_go_on_and_stop_and_the_terminal_is_given_back(monkeypatch):
    person, terminal = pty.openpty()
    monkeypatch.setattr("app.live.operator_console.in_terminal", lambda file: True)
    before = termios.tcgetattr(terminal)
    control = Control()
    with keys(control, terminal) as listening:
        assert listening
        assert not termios.tcgetattr(terminal)[3] & (termios.ECHO | termios.ICANON)
        os.write(person, b" ")
        until(lambda: control.state.paused)
        os.write(person, b"x")  # means nothing
        os.write(person, b"s")
        until(control.take_turn)
        assert not control.take_turn()
        os.write(person, b" ")  # never resumes
        os.write(person, b"s")
        until(control.take_turn)
        assert control.state.paused
        os.write(person, b"r")
        until(lambda: not control.state.paused)
        os.write(person, b"q")
        until(lambda: control.stopped)
    assert termios.tcgetattr(terminal) == before
    with pytest.raises(RuntimeError), keys(control, terminal):
        raise RuntimeError("the run breaks")
    assert termios.tcgetattr(terminal) == before
    os.close(person)
    os.close(terminal)
