"""A loop that really blocks, in real time: another thread stops the robot, and the run ends."""

import hashlib
import socket
import threading
import time

import pytest
from controlled_run import session_of
from harness import Harness, looking_down
from py_trees.common import Status

from app.core.outcome import End
from app.live import Control
from behaviours import Leaf
from controller import PoseGoal
from hw import LoopBlockedError, Patience, Refusal, Watchdog

pytestmark = pytest.mark.realtime

BLOCK_AT = 30
DEADLINE = 0.25
"""From the beginning of the block to the stop [s]."""


def sleep() -> None:
    time.sleep(60.0)


def swallow_everything() -> None:
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        try:
            time.sleep(1.0)
        except Exception:
            continue


def wait_for_a_socket() -> None:
    a, b = socket.socketpair()
    with a, b:
        a.recv(1)


def compute_in_c() -> None:
    hashlib.pbkdf2_hmac("sha256", b"x", b"y", 15_000_000)


class Driver(Leaf):
    key = "driver"

    def __init__(self, name, context) -> None:
        super().__init__(name, context)
        self.block = lambda: None

    def update(self) -> Status:
        self.pursue(PoseGoal(wTe=looking_down(4.0, 0.5, 0.8)))
        self.context.vision.new_frame()
        self.block()
        return self.running("driving")


class PacedRun:
    """A session in real time in which one call blocks from some tick on."""

    def __init__(self, place: str, block) -> None:
        self.harness = harness = Harness(real_clock=True)
        self.leaf = Driver("driver", harness.context)
        self.ticks = 0
        self.control = Control()
        owner, name = {
            "leaf": (self.leaf, "block"),
            "read": (harness.robot, "read"),
            "send": (harness.robot, "send"),
            "camera": (harness.context.vision._camera, "latest"),
            "controller": (harness.controller, "step"),
        }[place]
        call, self.blocked_at, self.stopped_at = getattr(owner, name), 0.0, 0.0

        def blocking(*args, **kwargs):
            if self.ticks >= BLOCK_AT and not self.blocked_at:
                self.blocked_at = time.monotonic()
                block()
            return call(*args, **kwargs)

        setattr(owner, name, blocking)
        stop = harness.robot.stop

        def noted_stop() -> None:
            self.stopped_at = self.stopped_at or time.monotonic()
            stop()

        harness.robot.stop = noted_stop

    def _watch(self, tick) -> None:
        self.ticks += 1
        if self.ticks == 300:
            self.control.stop()

    def run(self):
        session, self.measurements = session_of(self.harness, self.leaf, self.control, self._watch)
        self.outcome = session.run()
        return self.outcome


CASES = [
    ("leaf", swallow_everything, End.CRASH),
    ("leaf", compute_in_c, End.CRASH),
    ("controller", sleep, End.CRASH),
    ("send", wait_for_a_socket, End.HARDWARE),
    ("camera", sleep, End.CRASH),
]


def assert_ended(run: PacedRun, end: End) -> None:
    assert run.run().end is end
    assert "did not return in time" in run.outcome.reason
    if end is End.CRASH:
        assert run.outcome.node == "driver"
    assert run.measurements.stalls >= 1
    assert run.harness.speed < 1e-2


def test_what_blocks_is_stopped_by_another_thread_and_ends_the_run():
    run = PacedRun("read", wait_for_a_socket)
    assert_ended(run, End.HARDWARE)
    assert run.stopped_at


@pytest.mark.slow
@pytest.mark.parametrize(("place", "block", "end"), CASES)
def test_it_is_stopped_in_time(place, block, end):
    for _ in range(3):  # the machine may be busy: it has to be in time once
        run = PacedRun(place, block)
        assert_ended(run, end)
        if run.stopped_at - run.blocked_at <= DEADLINE:
            return
    raise AssertionError(f"stopped after {run.stopped_at - run.blocked_at:.3f} s")


@pytest.mark.slow
def test_a_stall_that_ends_by_itself_stops_the_robot_and_the_run_goes_on():
    run = PacedRun("leaf", lambda: time.sleep(0.5))
    assert run.run().end is End.INTERRUPTED  # by the test, at tick 300
    assert run.stopped_at
    assert run.measurements.missed_ticks >= 40
    assert run.harness.gate.refusals[Refusal.READING] == 1  # what was read before is too old
    assert run.measurements.limit_violations == 0


def test_what_cannot_be_interrupted_is_abandoned():
    abandoned = threading.Event()
    patience = Patience(stop=0.05, interrupt=0.1, abandon=0.2)
    with Watchdog(lambda: None, abandoned.set, patience):
        for _ in range(600):
            try:
                if abandoned.wait(0.1):
                    break
            except LoopBlockedError:
                continue
    assert abandoned.is_set()
