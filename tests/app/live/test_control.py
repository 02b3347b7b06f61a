"""Pausing, stepping and stopping a session, and the faults and breakpoints that come with it."""

import threading
import time

import numpy as np
import pytest
from harness import Harness, looking_down
from py_trees.common import Status

from app.core.measurements import Measurements
from app.core.outcome import End
from app.core.session import Session
from app.live.operator import (
    INJECTABLE,
    Act,
    Control,
    FaultInjection,
    Side,
    TaskClock,
    UnknownNodeError,
    insert_hooks,
    matching,
)
from behaviours import Context, Leaf
from controller import PoseGoal
from hw import FaultKind, SimClock
from trees.language import nodes_in_order
from trees.language.composites import Fallback, Sequence
from trees.language.modifiers import Retry, Timeout

AWAY = looking_down(3.0, 0.5, 0.8)


class Going(Leaf):
    """Heads far away for some ticks, and then ends as it is told."""

    key = "going"

    def __init__(self, name: str, context: Context, *, ticks: int, end=Status.SUCCESS) -> None:
        super().__init__(name, context)
        self._ticks, self._end = ticks, end
        self.begun = self.halted = 0
        self.updates: list[float] = []
        self.reports: list[bool] = []

    def initialise(self) -> None:
        self.begun += 1
        self._left = self._ticks

    def update(self) -> Status:
        self.reports.append(self.pursue(PoseGoal(wTe=AWAY)) is not None)
        self.updates.append(self.context.clock.now())
        self._left -= 1
        if self._left > 0:
            return self.running("going")
        self.feedback_message = "told to end"
        return self._end

    def terminate(self, new_status: Status) -> None:
        self.halted += self.status is Status.RUNNING


class Room:
    """A session whose tree is made of such leaves, with something to do after given ticks."""

    def __init__(self, make_root, at=None, hooked=(), real_seconds=20.0) -> None:
        self.harness = Harness()
        self.control = Control()
        self.clock = self.harness.task_clock
        self.ticks = []
        self._at = at or {}
        root = make_root(self.harness.context)
        self.nodes = nodes_in_order(root)
        self.reached = []
        self.root, self.hooks = insert_hooks(
            root, [n for name in hooked for n in matching(self.nodes, name)], self._reached
        )
        self._deadline = time.monotonic() + real_seconds

    def _reached(self, hook, side, act) -> None:
        self.reached.append((hook.name, side))
        if act.instead is None:
            self.control.pause(f"before {hook.name}")

    def _watch(self, tick) -> None:
        self.ticks.append(tick)
        if action := self._at.get(len(self.ticks)):
            action()
        assert time.monotonic() < self._deadline, "the run never ends"

    def run(self):
        controller = self.harness.controller
        self.measurements = Measurements(limits=controller.model.limits)
        return Session(
            root=self.root,
            context=self.harness.context,
            controller=controller,
            gate=self.harness.gate,
            measurements=self.measurements,
            clock=self.clock,
            control=self.control,
            watch=self._watch,
        ).run()

    def speed_after(self, ticks: int) -> float:
        state = self.ticks[ticks].state
        return float(max(np.abs(state.base_twist).max(), np.abs(state.qd).max()))

    def assert_kept_limits(self) -> None:
        commands = self.measurements.commands[:, 1:]
        limits = self.harness.controller.model.limits
        allowed = np.concatenate([limits.base_acceleration, limits.qdd]) * 0.01
        assert (np.abs(np.diff(commands, axis=0)) <= allowed + 1e-9).all()
        assert self.measurements.limit_violations == 0


def leaf(name="going", ticks=200, end=Status.SUCCESS):
    return lambda context: Going(name, context, ticks=ticks, end=end)


# pausing


def test_a_pause_brings_the_robot_smoothly_to_rest_and_it_goes_on_where_it_was():
    room = Room(leaf(ticks=200))
    room._at = {100: room.control.pause, 250: room.control.resume}
    outcome = room.run()
    assert outcome.end is End.SUCCESS
    assert room.speed_after(99) > 0.3
    assert room.speed_after(249) < 1e-3
    assert room.speed_after(340) > 0.3
    room.assert_kept_limits()
    going = room.nodes[0].node
    assert going.begun == 1  # not started again
    assert len(going.updates) == 200
    assert [tick.paused for tick in room.ticks].count(True) == 150


def test_a_pause_counts_in_no_timeout():
    room = Room(lambda context: Timeout(leaf(ticks=120)(context), 1.5, context.clock.now))
    room._at = {100: room.control.pause, 300: room.control.resume}
    outcome = room.run()
    assert outcome.end is End.SUCCESS  # 1.2 s of its own, 2 s paused
    times = [moment.seconds for moment in room.nodes[-1].node.updates]
    np.testing.assert_allclose(np.diff(times), 0.01, atol=1e-9)
    assert room.ticks[-1].state.stamp > 3.1  # the session's time went on


def test_a_step_is_one_tick_of_the_tree_and_steps_add_up():
    room = Room(leaf(ticks=30))

    def steps() -> None:
        room.control.step()
        room.control.step()

    counts = []
    room._at = {
        10: room.control.pause,
        20: lambda: (counts.append(room.control.state.ticks), steps()),
        40: lambda: (counts.append(room.control.state.ticks), room.control.resume()),
    }
    assert room.run().end is End.SUCCESS
    assert counts == [10, 12]
    assert [tick.paused for tick in room.ticks[:24]] == [False] * 10 + [True] * 10 + [
        False,
        False,
        True,
        True,
    ]


def test_a_leaf_that_is_stepped_finds_the_report_of_its_last_goal():
    room = Room(leaf(ticks=30))
    room._at = {10: room.control.pause} | dict.fromkeys(range(15, 60, 5), room.control.step)
    room._at[65] = room.control.resume
    room.run()
    assert room.nodes[0].node.reports == [False] + [True] * 29


def test_the_next_change_of_a_node_pauses_the_run():
    def root(context):
        first, second = leaf("first", 20)(context), leaf("second", 20)(context)
        return Sequence("sequence", [first, second])

    room = Room(root)
    statuses = []

    def watch_changes(tick) -> None:
        now = [place.node.status for place in room.nodes]
        if statuses and now != statuses[-1]:
            room.control.node_changed()
        statuses.append(now)
        Room._watch(room, tick)

    room._watch = watch_changes
    room._at = {5: room.control.run_to_next_change, 30: room.control.resume}
    assert room.run().end is End.SUCCESS
    paused = [tick.number for tick in room.ticks if tick.paused]
    assert paused[0] == 20  # in tick 19 the first ended and the second began
    assert len(paused) == 10


def test_a_stop_ends_a_paused_run_as_interrupted():
    room = Room(leaf(ticks=1000))
    room._at = {50: room.control.pause, 150: room.control.stop}
    outcome = room.run()
    assert outcome.end is End.INTERRUPTED
    assert outcome.end.exit_code == 130
    assert room.nodes[0].node.halted == 1
    assert room.harness.speed < 1e-3


def test_a_run_that_begins_paused_waits_for_a_person():
    room = Room(leaf(ticks=5))
    room.control.pause()
    room._at = {10: room.control.resume}
    assert room.run().end is End.SUCCESS
    assert len(room.nodes[0].node.updates) == 5
    assert all(tick.paused for tick in room.ticks[:10])


def test_the_control_may_be_told_from_another_thread():
    """Also without a pace: a paused simulation waits in real time and does not race ahead."""
    room = Room(leaf(ticks=100_000), real_seconds=30.0)

    def person() -> None:
        for action in (room.control.pause, room.control.step, room.control.resume):
            time.sleep(0.05)
            action()
        time.sleep(0.1)
        room.control.pause()
        time.sleep(0.5)
        paused.append(sum(tick.paused for tick in room.ticks))
        room.control.stop()

    paused: list[int] = []
    thread = threading.Thread(target=person)
    thread.start()
    assert room.run().end is End.INTERRUPTED
    thread.join()
    assert 5 <= paused[0] <= 70  # of 100 a second at most


def test_without_a_pause_the_clock_of_the_task_is_that_of_the_session():
    session = SimClock()
    clock = TaskClock(session)
    for number in range(1, 2000):
        session.sleep_until(number * 0.01)
        assert clock.now().seconds == session.now()


# breakpoints


def two_leaves(context):
    first, second = leaf("first", 20)(context), leaf("second", 20)(context)
    return Sequence("sequence", [first, second])


def test_a_breakpoint_pauses_before_the_node_does_anything():
    room = Room(two_leaves, hooked=["second"])
    room.hooks[0].acts = {Side.BEFORE: Act()}
    second = room.nodes[2].node
    begun = []
    room._at = {40: lambda: (begun.append(second.begun), room.control.resume())}
    assert room.run().end is End.SUCCESS
    assert begun == [0]
    assert second.begun == 1
    assert len(second.updates) == 20
    assert room.reached == [("second", Side.BEFORE)]


def test_a_run_that_is_stopped_at_a_breakpoint_never_touches_the_node():
    room = Room(two_leaves, hooked=["second"])
    room.hooks[0].acts = {Side.BEFORE: Act()}
    room._at = {40: room.control.stop}
    assert room.run().end is End.INTERRUPTED
    second = room.nodes[2].node
    assert (second.begun, second.halted, second.updates) == (0, 0, [])


def test_a_breakpoint_holds_every_time_the_node_is_entered_or_once():
    def root(context):
        return Retry(leaf("flaky", 3, Status.FAILURE)(context), 3)

    for once, times in ((False, 3), (True, 1)):
        room = Room(root, hooked=["flaky"])
        room.hooks[0].acts = {Side.BEFORE: Act(once=once)}
        room._at = dict.fromkeys(range(10, 60, 10), room.control.resume)
        assert room.run().end is End.FAILURE
        assert len(room.reached) == times


def test_a_node_can_be_replaced_and_the_tree_believes_it():
    def root(context):
        return Fallback("fallback", [leaf("doomed", 3)(context), leaf("rescue", 3)(context)])

    room = Room(root, hooked=["doomed"])
    room.hooks[0].acts = {Side.BEFORE: Act(instead=Status.FAILURE)}
    assert room.run().end is End.SUCCESS
    assert room.nodes[1].node.begun == 0
    assert room.nodes[2].node.begun == 1


def test_a_person_may_choose_the_outcome_after_a_node_has_ended():
    room = Room(two_leaves, hooked=["first"])
    room.hooks[0].acts = {Side.AFTER: Act()}

    def choose() -> None:
        room.hooks[0].answer = Status.FAILURE
        room.control.resume()

    room._at = {40: choose}
    outcome = room.run()
    assert outcome.end is End.FAILURE
    assert outcome.node == "first"
    assert outcome.reason == "failure chosen by a person"
    assert len(room.nodes[1].node.updates) == 20
    assert room.nodes[2].node.begun == 0


def test_hooks_that_do_nothing_change_nothing():
    def root(context):
        inner = Sequence("inner", [leaf("a", 3)(context), leaf("b", 3, Status.FAILURE)(context)])
        return Retry(inner, 2)

    plain, hooked = Room(root), Room(root, hooked=["retry", "inner", "a", "b"])
    outcomes = [plain.run(), hooked.run()]
    assert outcomes[0] == outcomes[1]
    assert plain.root.feedback_message == hooked.root.feedback_message
    assert plain.measurements.commands.tobytes() == hooked.measurements.commands.tobytes()
    assert len(plain.ticks) == len(hooked.ticks)


def test_nodes_are_found_by_name_key_and_path():
    nodes = Room(two_leaves).nodes
    assert [n.name for n in matching(nodes, "second")] == ["second"]
    assert [n.name for n in matching(nodes, "going")] == ["first", "second"]
    assert [n.name for n in matching(nodes, "sequence/first")] == ["first"]
    with pytest.raises(UnknownNodeError, match="did you mean `second`"):
        matching(nodes, "secund")


# faults


@pytest.mark.parametrize("name", INJECTABLE)
def test_an_injected_fault_stops_the_robot_until_it_is_cleared(name):
    room = Room(leaf(ticks=400))
    robot = FaultInjection(room.harness.robot)
    room.harness.context.robot = robot

    def clear() -> None:
        robot.clear()
        room.harness.gate.release()

    room._at = {100: lambda: robot.inject(name), 250: clear}
    room.run()
    assert room.speed_after(99) > 0.3
    assert room.speed_after(249) < 1e-3
    assert room.speed_after(390) > 0.3
    assert [fault.kind for fault in room.ticks[200].state.faults] == [FaultKind(name)]


def test_recovery_clears_the_injected_faults_that_a_program_may_clear():
    robot = FaultInjection(Harness().robot)
    for name in INJECTABLE:
        robot.inject(name)
    robot.recover()
    assert {fault.kind for fault in robot.read().faults} == {
        FaultKind.EMERGENCY_STOP,
        FaultKind.STALE_POSE,
    }
