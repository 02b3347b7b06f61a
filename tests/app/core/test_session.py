"""The loop: however the tree ends, the robot is at rest and the outcome says why."""

import gc
import time
from dataclasses import replace

import numpy as np
import pytest
from controlled_run import ControlledRun, Going, leaf
from harness import REFLEX
from py_trees.common import Status

from app.core.measurements import Durations
from app.core.outcome import End
from behaviours import Recover
from hw import Refusal
from trees.words.composites import Forever
from trees.words.modifiers import Retry


def test_success_ends_the_run_with_the_robot_at_rest():
    frozen: list[int] = []  # collecting garbage would delay ticks
    run = ControlledRun(leaf(ticks=100), at={50: lambda: frozen.append(gc.get_freeze_count())})
    gc.unfreeze()  # what was frozen for all tests
    try:
        assert run.run().end is End.SUCCESS
        assert frozen[0] > 10_000
        assert gc.get_freeze_count() == 0
    finally:
        gc.freeze()
    assert run.outcome.end.exit_code == 0
    run.assert_came_smoothly_to_rest()


def test_failure_names_the_leaf_and_its_reason():
    run = ControlledRun(leaf("runner", 100, Status.FAILURE))
    outcome = run.run()
    assert (outcome.end, outcome.end.exit_code) == (End.FAILURE, 1)
    assert (outcome.node, outcome.reason) == ("runner", "told to end")
    run.assert_came_smoothly_to_rest()


@pytest.mark.parametrize("attended", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_what_comes_back_again_and_again_ends_an_unattended_run_and_else_pauses_it(attended):
    """A loop starts `recover` again and again."""

    def root(context):
        now, log = context.clock.now, context.log
        return Forever(
            "forever", [Retry(Recover("recover", context), 5, now)], now, lambda: log.placed
        )

    run, cleared, paused = ControlledRun(root), [], []
    robot, clock = run.harness.robot, run.harness.clock
    robot.faults, robot.incurable = (REFLEX,), True
    run.control.attended = attended
    recover = robot.recover
    robot.recover = lambda: (cleared.append(clock.now()), recover())

    def see_to_it(tick) -> None:
        if tick.paused and not paused:
            paused.append(run.control.state.why)
            robot.incurable = False
            run.control.resume()

    run._watch = see_to_it
    outcome = run.run()
    if attended:
        assert outcome.end is End.SUCCESS
        assert paused == ["came back 3 times: the arm hit something; see to it, then resume"]
    else:
        assert outcome.end is End.HARDWARE
        told = "came back 3 times: the arm hit something; nobody is here to see to it"
        assert outcome.reason == told
        assert clock.now() < 11.0
    assert len(cleared) == 3 + attended


def test_every_reading_is_held_against_the_limits():
    run = ControlledRun(leaf(ticks=100))
    run.run()
    measured = run.measurements
    assert measured.limit_violations == 0
    assert 0.5 < measured.highest_speed <= 1.0 + 1e-9
    measured.reading(replace(run.ticks[-1].state, qd=np.full(7, 3.0)))
    assert measured.limit_violations == 1


def test_late_ticks_are_counted_with_what_they_tell_watchers():
    run = ControlledRun(leaf(ticks=10), at=dict.fromkeys((3, 7), lambda: time.sleep(0.03)))
    run.run()
    assert run.measurements.late_ticks >= 2
    stamps = np.array([tick.state.stamp for tick in run.ticks])
    np.testing.assert_allclose(np.diff(stamps), 0.01, atol=1e-12)  # the next ticks are not shifted


def test_quantiles_are_within_one_percent_in_bounded_memory():
    values = np.random.default_rng(0).lognormal(-8.0, 1.5, 50_000)
    durations = Durations()
    for value in values:
        durations.append(value)
    assert len(durations) == len(values)
    assert len(durations._counts) < 1000
    for share in (0.01, 0.5, 0.99):
        assert durations.quantile(share) == pytest.approx(np.quantile(values, share), rel=0.011)
    assert Durations().quantile(0.5) == 0.0


def test_on_a_real_clock_no_command_that_follows_a_late_one_comes_too_soon():
    class Late(Going):
        def update(self) -> Status:
            run.harness.clock._now += 0.018 if len(run.ticks) % 4 == 0 else 0.001  # it thinks
            return super().update()

    run = ControlledRun(lambda context: Late("late", context, ticks=60))
    run.harness.clock.is_real = True
    run.run()
    assert run.harness.gate.refusals[Refusal.ACCELERATION] == 0
