"""A loop that really blocks, in real time: another thread stops the robot, and the run ends."""

import hashlib
import socket
import time

import pytest
from controlled_run import TroubledRun

from app.core.outcome import End
from hw import Refusal

pytestmark = pytest.mark.realtime

DEADLINE = 0.25
"""From the beginning of the block to the stop [s]."""


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


class BlockedRun(TroubledRun):
    """A session in real time in which one call blocks once."""

    def __init__(self, place: str, block) -> None:
        super().__init__(place, self._block, since=30, until=300, real_clock=True)
        self._blocks, self.blocked_at = block, 0.0

    def _block(self) -> None:
        if not self.blocked_at:
            self.blocked_at = time.monotonic()
            self._blocks()

    def assert_ended(self, end: End) -> None:
        assert self.run().end is end
        assert "did not return in time" in self.outcome.reason
        assert end is not End.CRASH or self.outcome.node == "driver"
        assert self.measurements.stalls >= 1
        assert self.harness.speed < 1e-2
        assert self.stops


def test_what_blocks_is_stopped_by_another_thread_and_ends_the_run():
    BlockedRun("read", wait_for_a_socket).assert_ended(End.HARDWARE)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "block", "end"),
    [
        ("leaf", swallow_everything, End.CRASH),
        ("leaf", compute_in_c, End.CRASH),
        ("controller", lambda: time.sleep(60.0), End.CRASH),
        ("send", wait_for_a_socket, End.HARDWARE),
    ],
)
def test_it_is_stopped_in_time(place, block, end):
    run = BlockedRun(place, block)
    run.assert_ended(end)
    assert run.stops[0] - run.blocked_at <= DEADLINE


@pytest.mark.slow
def test_a_stall_that_ends_by_itself_stops_the_robot_and_the_run_goes_on():
    run = BlockedRun("leaf", lambda: time.sleep(0.5))
    assert run.run().end is End.INTERRUPTED  # by the test
    assert run.stops
    assert run.measurements.missed_ticks >= 40
    assert run.harness.gate.refusals[Refusal.READING] == 1  # what was read before is too old
    assert run.measurements.limit_violations == 0
