"""A loop that was late is replayed as it was: the gate decides by the same moments again."""

from __future__ import annotations

import numpy as np
import pytest
from pinocchio import SE3

from controller import Command
from hw import Gate, RecordedRobot, RobotState
from hw.replay import ReplayRobot
from robots import load_robot

FRANKIE = load_robot("frankie")
DT = 0.01
TURNS = 200


class BusyClock:
    """Real time on a busy computer: between any two looks passes another time."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng, self._now = rng, 0.0

    def now(self) -> float:
        self._now += self._rng.uniform(0.0005, 0.006)
        return self._now

    def sleep_until(self, stamp: float) -> None:
        self._now = max(self._now, stamp)

    @property
    def is_real(self) -> bool:
        return True


class Follower:
    """Where hardware would stand: it does at once what it is told."""

    def __init__(self, clock: BusyClock) -> None:
        self.clock, self.applied, self.q = clock, Command.stop(), FRANKIE.arm.ready.copy()

    def read(self) -> RobotState:
        return RobotState(
            stamp=self.clock.now(),
            wTb=SE3.Identity(),
            base_twist=self.applied.base_twist,
            q=self.q.copy(),
            qd=self.applied.qd,
            gripper_width=0.08,
            gripper_moving=False,
        )

    def send(self, command: Command) -> Command:
        self.q = self.q + DT * command.qd
        self.applied = command
        return command


class Kept:
    """Keeps every turn."""

    def __init__(self) -> None:
        self.rows: list[np.ndarray] = []

    def turn(self, row) -> None:
        self.rows.append(row.copy())


def drive(robot, clock, gate) -> None:
    """As the loop does: a reading, its moment, a command that asks for all that 10 ms allow."""
    for number in range(TURNS):
        state, now = robot.read(), clock.now()
        last = gate.continue_from(state, now)
        faster = FRANKIE.limits.qdd * DT * (1.0 if number % 20 < 10 else -1.0)
        gate.send(Command(base_twist=last.base_twist, qd=last.qd + faster), state, clock.now())
        clock.sleep_until(DT * (number + 1))


@pytest.mark.parametrize("seed", range(5))
def test_what_the_gate_refused_for_its_moment_is_refused_again(seed):
    busy = BusyClock(np.random.default_rng(seed))
    recorded, kept = RecordedRobot(Follower(busy), busy), Kept()
    recorded.record(kept)
    gate = Gate(recorded, FRANKIE, DT)
    drive(recorded, recorded.clock, gate)
    recorded.end()
    refused = sum(gate.refusals.values())
    assert 0 < refused < TURNS

    replay = ReplayRobot(FRANKIE, np.stack(kept.rows), {}, lambda number: None)
    replay.begin()
    again = Gate(replay, FRANKIE, DT)
    drive(replay, replay.clock, again)
    assert replay.sent == TURNS
    assert again.refusals == gate.refusals
