"""Pausing, stepping and stopping a session, and injected faults."""

import threading
import time

import numpy as np
import pytest
from controlled_run import ControlledRun, leaf
from harness import Harness

from app.core.outcome import End
from hw import FaultInjection, FaultKind, SimClock, TaskClock
from trees.language.composites import Sequence
from trees.language.modifiers import Timeout


def test_a_pause_brings_the_robot_smoothly_to_rest_and_it_goes_on_where_it_was():
    run = ControlledRun(leaf(ticks=200))
    run._at = {100: run.control.pause, 250: run.control.resume}
    outcome = run.run()
    assert outcome.end is End.SUCCESS
    assert run.speed_after(99) > 0.3
    assert run.speed_after(249) < 1e-3
    assert run.speed_after(340) > 0.3
    run.assert_kept_limits()
    going = run.nodes[0].node
    assert going.begun == 1  # not started again
    assert len(going.updates) == 200
    assert [tick.paused for tick in run.ticks].count(True) == 150


def test_a_pause_counts_in_no_timeout():
    run = ControlledRun(lambda context: Timeout(leaf(ticks=120)(context), 1.5, context.clock.now))
    run._at = {100: run.control.pause, 300: run.control.resume}
    outcome = run.run()
    assert outcome.end is End.SUCCESS  # 1.2 s of its own, 2 s paused
    times = [moment.seconds for moment in run.nodes[-1].node.updates]
    np.testing.assert_allclose(np.diff(times), 0.01, atol=1e-9)
    assert run.ticks[-1].state.stamp > 3.1  # the session's time went on


def test_a_step_is_one_tick_of_the_tree_and_steps_add_up():
    run = ControlledRun(leaf(ticks=30))

    def steps() -> None:
        run.control.step()
        run.control.step()

    counts = []
    run._at = {
        10: run.control.pause,
        20: lambda: (counts.append(run.control.state.ticks), steps()),
        40: lambda: (counts.append(run.control.state.ticks), run.control.resume()),
    }
    assert run.run().end is End.SUCCESS
    assert counts == [10, 12]
    assert [tick.paused for tick in run.ticks[:24]] == [False] * 10 + [True] * 10 + [
        False,
        False,
        True,
        True,
    ]


def test_a_leaf_that_is_stepped_finds_the_report_of_its_last_goal():
    run = ControlledRun(leaf(ticks=30))
    run._at = {10: run.control.pause} | dict.fromkeys(range(15, 60, 5), run.control.step)
    run._at[65] = run.control.resume
    run.run()
    assert run.nodes[0].node.reports == [False] + [True] * 29


def test_the_next_change_of_a_node_pauses_the_run():
    def root(context):
        first, second = leaf("first", 20)(context), leaf("second", 20)(context)
        return Sequence("sequence", [first, second])

    run = ControlledRun(root)
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
    paused = [tick.number for tick in run.ticks if tick.paused]
    assert paused[0] == 20  # in tick 19 the first ended and the second began
    assert len(paused) == 10


def test_a_stop_ends_a_paused_run_as_interrupted():
    run = ControlledRun(leaf(ticks=1000))
    run._at = {50: run.control.pause, 150: run.control.stop}
    outcome = run.run()
    assert outcome.end is End.INTERRUPTED
    assert outcome.end.exit_code == 130
    assert run.nodes[0].node.halted == 1
    assert run.harness.speed < 1e-3


def test_a_run_that_begins_paused_waits_for_a_person():
    run = ControlledRun(leaf(ticks=5))
    run.control.pause()
    run._at = {10: run.control.resume}
    assert run.run().end is End.SUCCESS
    assert len(run.nodes[0].node.updates) == 5
    assert all(tick.paused for tick in run.ticks[:10])


def test_the_control_may_be_told_from_another_thread():
    """Also without a pace: a paused simulation waits in real time and does not race ahead."""
    run = ControlledRun(leaf(ticks=100_000), real_seconds=30.0)

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


def test_without_a_pause_the_clock_of_the_task_is_that_of_the_session():
    session = SimClock()
    clock = TaskClock(session)
    for number in range(1, 2000):
        session.sleep_until(number * 0.01)
        assert clock.now().seconds == session.now()


REPORTED = ["reflex", "emergency stop", "stale pose"]


@pytest.mark.parametrize("name", REPORTED)
def test_an_injected_fault_stops_the_robot_until_it_is_cleared(name):
    run = ControlledRun(leaf(ticks=400))
    robot = FaultInjection(run.harness.robot)
    run.harness.context.robot = robot

    def clear() -> None:
        robot.clear()
        run.harness.gate.release()

    run._at = {100: lambda: robot.inject(name), 250: clear}
    run.run()
    assert run.speed_after(99) > 0.3
    assert run.speed_after(249) < 1e-3
    assert run.speed_after(390) > 0.3
    assert [fault.kind for fault in run.ticks[200].state.faults] == [FaultKind(name)]


def test_recovery_clears_the_injected_faults_that_a_program_may_clear():
    robot = FaultInjection(Harness().robot)
    for name in REPORTED:
        robot.inject(name)
    robot.recover()
    assert {fault.kind for fault in robot.read().faults} == {
        FaultKind.EMERGENCY_STOP,
        FaultKind.STALE_POSE,
    }
