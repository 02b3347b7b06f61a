"""Pausing, stepping and stopping a session, and injected faults."""

import threading
import time

import numpy as np
from controlled_run import ControlledRun, leaf

from app.core.outcome import End
from hw import FaultInjection
from trees.words.composites import Sequence
from trees.words.modifiers import Timeout


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
    paused = [tick.paused for tick in run.ticks[:24]]
    assert paused == [False] * 10 + [True] * 10 + [False] * 2 + [True] * 2


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


def injected(ticks: int = 400) -> tuple[ControlledRun, FaultInjection]:
    run = ControlledRun(leaf(ticks=ticks))
    run.harness.context.robot = FaultInjection(run.harness.robot)
    return run, run.harness.context.robot


def test_what_only_a_person_may_clear_pauses_the_run_until_a_person_resumes_it():
    run, robot = injected()
    run._at = {100: lambda: robot.inject("stale pose"), 250: robot.clear, 350: run.control.resume}
    assert run.run().end is End.SUCCESS
    assert run.speed_after(249) < 1e-3
    assert [tick.paused for tick in run.ticks].count(True) == 250
    assert run.speed_after(349) < 1e-3
    assert run.speed_after(450) > 0.3


def test_a_released_emergency_stop_waits_for_a_person_who_acknowledges_and_then_resumes():
    run, robot = injected()
    whys = []

    def note(act) -> None:
        act()
        whys.append(run.control.state.why)

    run._at = {
        100: lambda: robot.inject("emergency stop"),
        150: lambda: note(run.control.acknowledge),  # still pressed
        160: run.control.resume,
        200: robot.clear,
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
        "emergency stop, injected",
        "emergency stop: released, not yet acknowledged",
        "emergency stop acknowledged",
    ]
    run.assert_kept_limits(emergency=True)


def test_an_emergency_stop_that_nobody_can_acknowledge_ends_the_run():
    run, robot = injected()
    run.control.attended = False
    run._at = {100: lambda: robot.inject("emergency stop")}
    outcome = run.run()
    assert outcome.end is End.HARDWARE
    assert outcome.reason == "emergency stop, injected; nobody is here to acknowledge it"
    assert run.speed_after(-1) < 1e-3


def test_from_one_metre_per_second_an_emergency_stop_takes_at_most_six_tenths_of_a_second():
    run, robot = injected(ticks=1000)
    run._at = {180: lambda: robot.inject("emergency stop"), 300: run.control.stop}
    run.run()
    speeds = [float(np.abs(tick.state.base_twist[:1]).max()) for tick in run.ticks]
    assert speeds[180] > 0.99
    assert max(speeds[180 + 60 :]) < 0.01
