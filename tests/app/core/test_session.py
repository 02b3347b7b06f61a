"""The loop: whatever happens in the tree, the robot ends at rest and the outcome says why."""

import gc
import time

import numpy as np
import pytest
from controlled_run import session_of
from harness import BUTTON, REFLEX, Harness, looking_down
from pinocchio import SE3
from py_trees.common import Status

from app.core.outcome import End
from app.live import Control
from behaviours import Context, Leaf, Recover
from controller import PoseGoal
from trees.words.composites import Forever, Sequence
from trees.words.modifiers import Retry

AWAY = looking_down(3.0, 0.5, 0.8)


class Scripted(Leaf):
    """Heads for a far goal, and does what a test wants after some ticks."""

    key = "scripted"

    def __init__(self, name: str, context: Context, *, ticks: int, then) -> None:
        super().__init__(name, context)
        self._ticks = ticks
        self._then = then
        self.halted = 0

    def update(self) -> Status:
        self.pursue(PoseGoal(wTe=AWAY))
        self._ticks -= 1
        return self._then() if self._ticks < 0 else self.running("going")

    def terminate(self, new_status: Status) -> None:
        self.halted += self.status is Status.RUNNING


class Bench:
    """A session around one scripted leaf."""

    def __init__(self, then, ticks: int = 100, interrupt_after: int | None = None) -> None:
        self.harness = Harness()
        self.leaf = Scripted("runner", self.harness.context, ticks=ticks, then=then)
        self.ticks = []
        self.control = Control()
        self._interrupt_after = interrupt_after
        self.session, self.measurements = session_of(
            self.harness, Sequence("sequence", [self.leaf]), self.control, self._watch
        )

    def _watch(self, tick) -> None:
        self.ticks.append(tick)
        if len(self.ticks) == self._interrupt_after:
            self.control.stop()

    def run(self):
        self.outcome = self.session.run()
        return self.outcome

    @property
    def commands(self) -> np.ndarray:
        """(ticks, 10) as they were applied."""
        return np.array([[*tick.applied.base_twist, *tick.applied.qd] for tick in self.ticks])

    def assert_came_smoothly_to_rest(self) -> None:
        assert self.harness.speed < 1e-3
        commands = self.commands
        assert np.abs(commands).max() > 0.5  # it was really moving
        assert np.abs(commands[-1]).max() < 1e-3
        limits = self.harness.controller.model.limits
        stopped = self.outcome.end not in (End.SUCCESS, End.FAILURE)
        base = limits.base_emergency if stopped else limits.base_acceleration
        allowed = np.concatenate([base, limits.qdd]) * 0.01
        assert (np.abs(np.diff(commands, axis=0)) <= allowed + 1e-9).all()


def test_success_ends_the_run_with_the_robot_at_rest():
    frozen: list[int] = []

    def succeed() -> Status:
        frozen.append(gc.get_freeze_count())  # collecting garbage would delay ticks
        return Status.SUCCESS

    bench = Bench(succeed)
    gc.unfreeze()  # what was frozen for all tests
    try:
        assert bench.run().end is End.SUCCESS
        assert frozen[0] > 10_000
        assert gc.get_freeze_count() == 0
    finally:
        gc.freeze()
    assert bench.outcome.end.exit_code == 0
    bench.assert_came_smoothly_to_rest()


def test_failure_names_the_leaf_and_its_reason():
    bench = Bench(lambda: bench.leaf.failure("lost the way"))
    outcome = bench.run()
    assert outcome.end is End.FAILURE
    assert outcome.end.exit_code == 1
    assert (outcome.node, outcome.reason) == ("runner", "lost the way")
    bench.assert_came_smoothly_to_rest()


def test_a_goal_that_is_not_finite_never_moves_the_robot_and_names_the_node():
    def nonsense() -> Status:
        nowhere = SE3(np.eye(3), np.array([np.nan, 0.0, 0.0]))
        bench.leaf.pursue(PoseGoal(wTe=nowhere))
        return Status.RUNNING

    bench = Bench(nonsense)
    outcome = bench.run()
    assert outcome.end is End.CRASH
    assert outcome.node == "runner"
    assert "goal pose must be finite" in outcome.reason
    assert np.isfinite(bench.commands).all()
    bench.assert_came_smoothly_to_rest()


def test_an_interrupt_halts_the_tree_and_brings_the_robot_to_rest():
    bench = Bench(lambda: Status.RUNNING, interrupt_after=150)
    assert bench.run().end is End.INTERRUPTED
    assert bench.outcome.end.exit_code == 130
    assert bench.leaf.halted == 1
    bench.assert_came_smoothly_to_rest()


def test_an_emergency_stop_brakes_whatever_the_tree_says():
    bench = Bench(lambda: Status.RUNNING, ticks=10**6, interrupt_after=300)
    read = bench.harness.robot.read

    def pressed():
        if len(bench.ticks) == 100:
            bench.harness.robot.faults = (BUTTON,)
        return read()

    bench.harness.robot.read = pressed
    bench.run()
    at_100, later = bench.ticks[100].state, bench.ticks[220].state
    assert np.abs(at_100.base_twist).max() > 0.3
    assert np.abs(later.base_twist).max() < 1e-3


class TriesForEver(Bench):
    """A session around a `recover` that a loop starts again and again."""

    def __init__(self, *, attended: bool) -> None:
        super().__init__(lambda: Status.RUNNING)
        context, robot = self.harness.context, self.harness.robot
        robot.faults, robot.incurable = (REFLEX,), True
        self.control.attended = attended
        self.cleared = []
        recover = robot.recover
        robot.recover = lambda: (self.cleared.append(self.harness.clock.now()), recover())
        log = context.log
        loop = Forever(
            "forever",
            [Retry(Recover("recover", context), 5, context.clock.now)],
            context.clock.now,
            lambda: log.placed,
        )
        self.session._root = loop


def test_what_comes_back_again_and_again_ends_an_unattended_run_at_once():
    bench = TriesForEver(attended=False)
    outcome = bench.run()
    assert outcome.end is End.HARDWARE
    assert outcome.reason == (
        "came back 3 times: the arm hit something; nobody is here to see to it"
    )
    assert len(bench.cleared) == 3
    assert bench.harness.clock.now() < 11.0


@pytest.mark.slow
def test_what_comes_back_again_and_again_pauses_until_a_person_has_seen_to_it():
    bench = TriesForEver(attended=True)
    paused = []

    def watch(tick) -> None:
        if tick.paused and not paused:
            paused.append(bench.control.state.why)
            bench.harness.robot.faults = (REFLEX,)
            bench.harness.robot.incurable = False
            bench.control.resume()

    bench.session._watch = watch
    outcome = bench.run()
    assert paused == ["came back 3 times: the arm hit something; see to it, then resume"]
    assert outcome.end is End.SUCCESS
    assert len(bench.cleared) == 4


def test_every_reading_is_held_against_the_limits():
    bench = Bench(lambda: Status.SUCCESS)
    bench.run()
    assert bench.measurements.limit_violations == 0
    assert 0.5 < bench.measurements.highest_speed <= 1.0 + 1e-9
    state = bench.ticks[-1].state
    too_fast = type(state)(**{**vars(state), "qd": np.full(7, 3.0)})
    bench.measurements.reading(too_fast)
    assert bench.measurements.limit_violations == 1


def test_late_ticks_are_counted_with_what_they_tell_watchers():
    bench = Bench(lambda: Status.SUCCESS, ticks=10)
    watch, slow = bench.session._watch, {3, 7}

    def slow_watch(tick) -> None:
        watch(tick)
        if tick.number in slow:
            time.sleep(0.03)

    bench.session._watch = slow_watch
    bench.run()
    assert bench.measurements.late_ticks >= len(slow)
    stamps = np.array([tick.state.stamp for tick in bench.ticks])
    np.testing.assert_allclose(np.diff(stamps), 0.01, atol=1e-12)  # the next ticks are not shifted


def test_the_same_run_gives_the_same_commands_bit_for_bit():
    runs = []
    for _ in range(2):
        bench = Bench(lambda: Status.SUCCESS, ticks=60)
        bench.run()
        runs.append(bench.commands.tobytes())
    assert runs[0] == runs[1]
