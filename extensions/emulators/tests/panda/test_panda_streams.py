"""Whatever is commanded, no sample at 1 kHz is beyond what the arm may do, as the arm sees it.

Driver and emulated arm are stepped together in simulated time: `Lead` and the shared memory that
commands go through, the callback of the arm's process, and the emulated arm with its own checks and
its way of going on where a packet is lost. Left out are what makes real time: sockets, processes
and threads, the vendor's library with its own limiter, and that the system wakes late;
test_panda_driver.py goes through all of them, with fewer commands.
"""

from collections import deque
from types import SimpleNamespace

import numpy as np
import pytest

from drivers.panda import LIMITS, Mode
from drivers.panda.arm import Lead
from drivers.panda.records import ARM_COMMAND
from drivers.panda.streaming import Streaming
from drivers.processes.mailbox import Mailbox, open_memory, share_memory
from extensions.emulators.panda import EmulatedArm, LaggedJoints, MotionCommand

TICKS = 200
PERIOD = 0.001
ROUNDING = 1.0 + 1e-6


@pytest.fixture(autouse=True)
def no_alarm(monkeypatch):
    """This process does not end when it hangs."""
    monkeypatch.setattr("drivers.panda.streaming.still_alive", lambda: None)


class Commander:
    """A broken program: steps, reversals, swings, enormous values, pauses and stops."""

    def __init__(self, rng: np.random.Generator, mailbox: Mailbox) -> None:
        self.rng, self.mailbox = rng, mailbox
        self.lead = Lead(float(rng.choice([0.0, 0.025, 0.1])), LIMITS.qdd)
        self.fastest = np.array(LIMITS.qd) * rng.uniform(0.05, 1.5)
        self.kind, self.swing = rng.integers(4), rng.uniform(1.0, 200.0)
        self.hold = int(1000 // rng.choice([5, 20, 50, 100, 200]))
        self.number = self.pause = 0
        self.mailbox.put(0, 0.0, *np.zeros(7))

    def tick(self, tick: int) -> None:
        if tick < self.pause or tick % self.hold:
            return
        rng, now, self.number = self.rng, tick * PERIOD, self.number + 1
        if rng.random() < 0.02:
            self.pause = tick + int(rng.integers(20, 150))
        if rng.random() < 0.02:
            self.mailbox.put(self.number, -1.0, *np.zeros(7))
            return
        fastest = self.fastest
        wanted = (
            rng.uniform(-fastest, fastest),
            np.sign(rng.uniform(-1.0, 1.0, 7)) * fastest,
            fastest * np.sin(self.swing * now),
            rng.choice([-1e300, -10.0, 0.0, 10.0, 1e300], 7),
        )[self.kind]
        self.mailbox.put(self.number, now, *self.lead.of(wanted, now))


class Command(SimpleNamespace):
    """In place of the vendor's."""

    def __init__(self, qd) -> None:
        super().__init__(qd=tuple(qd), motion_finished=False)


class Line:
    """States on their way to the driver, and its answers: some are lost, some come late."""

    def __init__(self, rng: np.random.Generator, arm: EmulatedArm) -> None:
        self.rng, self.arm = rng, arm
        self.lost, self.late = rng.choice([0.0, 0.01, 0.05], 2)
        self.waiting: deque[tuple[int, SimpleNamespace]] = deque()
        self.seen = 0

    def answers(self, streaming: Streaming) -> MotionCommand | None:
        """What comes back for the state of this tick, before the next."""
        arm, rng, number = self.arm, self.rng, self.arm.number
        state = SimpleNamespace(number=number, q_d=arm.q_d, dq_d=arm.qd_d, ddq_d=arm.qdd_d)
        if rng.random() >= self.lost:
            self.waiting.append((number + (5 if rng.random() < self.late else 0), state))
        newest = None
        for due in [one for one in self.waiting if one[0] <= number]:
            self.waiting.remove(due)
            gap, self.seen = due[1].number - self.seen, max(self.seen, due[1].number)
            command = streaming(due[1], SimpleNamespace(to_msec=lambda gap=gap: gap))
            if due[1].number == number and rng.random() >= self.lost:
                newest = MotionCommand(number, command.qd, command.motion_finished)
        return newest


class Samples:
    """Every millisecond of a motion against the limits, whoever decided it."""

    def __init__(self, arm: EmulatedArm) -> None:
        self.arm, self.qdd, self.judged = arm, arm.qdd_d, 0

    def judge(self, is_commanded: bool) -> None:
        arm, before = self.arm, self.qdd
        self.qdd = arm.qdd_d
        if arm.mode is not Mode.MOVE:
            return
        self.judged += 1
        for q, low, high in zip(arm.q_d, LIMITS.q_min, LIMITS.q_max, strict=True):
            assert low <= q <= high
        for values, most in ((arm.qd_d, LIMITS.qd), (arm.qdd_d, LIMITS.qdd)):
            assert all(abs(v) <= m * ROUNDING for v, m in zip(values, most, strict=True))
        if is_commanded:  # what the arm does by itself when a packet is lost is not ours
            rows = zip(before, arm.qdd_d, LIMITS.qddd, strict=True)
            assert all(abs(b - a) <= PERIOD * m * ROUNDING for a, b, m in rows)


def drive(seed: int, mailbox: Mailbox) -> int:
    """One stream from anywhere in the range of the joints; how many samples were judged."""
    rng = np.random.default_rng(seed)
    low, high = np.array(LIMITS.q_min) + 0.002, np.array(LIMITS.q_max) - 0.002
    arm = EmulatedArm(LaggedJoints(tuple(map(float, rng.uniform(low, high)))), LIMITS)
    commander, line, samples = Commander(rng, mailbox), Line(rng, arm), Samples(arm)
    time = SimpleNamespace(now=0.0)

    def begin() -> Streaming:
        arm.begin_motion()
        return Streaming(
            LIMITS, mailbox, lambda *_: None, lambda: False, Command, now=lambda: time.now
        )

    streaming, command = begin(), None
    for tick in range(TICKS):
        time.now = tick * PERIOD
        commander.tick(tick)
        arm.tick(command)
        assert not arm.errors, f"stream {seed}: {arm.errors} after {tick} ms"
        samples.judge(command is not None)
        if arm.mode is Mode.IDLE:
            streaming = begin()
        command = line.answers(streaming)
    seen = arm.seen
    assert not seen.violations
    assert max(seen.speed, seen.acceleration, seen.jerk) <= ROUNDING
    assert seen.commands > 0.7 * TICKS
    return samples.judged


@pytest.mark.parametrize("streams", [25, pytest.param(500, marks=pytest.mark.slow)])
def test_wild_streams_leave_no_limit(streams):
    mailbox = Mailbox(open_memory(share_memory(1)), 0, ARM_COMMAND)
    assert sum(drive(seed, mailbox) for seed in range(streams)) > 0.99 * TICKS * streams
