"""Replay of a late loop: the gate decides by the recorded times again."""

import numpy as np
import pytest
from pinocchio import SE3

from controller import Command
from hw import Gate, LaserScan, RecordedRobot, RobotState
from hw.replay_robot import ReplayRobot
from hw.robot import Sensor
from robots import load_robot

FRANKIE = load_robot("frankie")
DT = 0.01
TURNS = 200


class BusyClock:
    """Real time on a busy computer: some time passes between any two calls."""

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
    description = FRANKIE

    def __init__(self, clock: BusyClock) -> None:
        self.clock, self.applied, self.q = clock, Command.stop(7), FRANKIE.arm.ready.copy()

    def read(self) -> RobotState:
        return RobotState(
            stamp=self.clock.now(),
            oTb=SE3.Identity(),
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
    def __init__(self) -> None:
        self.rows: list[np.ndarray] = []

    def turn(self, row) -> None:
        self.rows.append(row.copy())


def drive(robot, clock, gate) -> None:
    """A loop that commands the largest change of velocity in 10 ms."""
    for number in range(TURNS):
        state, now = robot.read(), clock.now()
        last = gate.continue_from(state, now)
        faster = FRANKIE.limits.qdd * DT * (1.0 if number % 20 < 10 else -1.0)
        gate.send(Command(base_twist=last.base_twist, qd=last.qd + faster), state, clock.now())
        clock.sleep_until(DT * (number + 1))


@pytest.mark.parametrize("seed", range(2))
def test_a_refusal_that_depends_on_time_is_repeated(seed):
    busy = BusyClock(np.random.default_rng(seed))
    recorded, kept = RecordedRobot(Follower(busy), busy), Kept()
    recorded.record(kept)
    gate = Gate(recorded, FRANKIE, DT)
    drive(recorded, recorded.clock, gate)
    recorded.end()
    refused = sum(gate.refusals.values())
    assert 0 < refused < TURNS

    replay = ReplayRobot(FRANKIE, np.stack(kept.rows), lambda field, number: None)
    replay.begin()
    again = Gate(replay, FRANKIE, DT)
    drive(replay, replay.clock, again)
    assert replay.sent == TURNS
    assert again.refusals == gate.refusals


def test_all_who_ask_for_a_scan_in_one_turn_get_the_same_one():
    busy = BusyClock(np.random.default_rng(0))
    inner, things = Follower(busy), []
    scans = iter(range(10))
    inner.laser = Sensor(
        lambda age: LaserScan(
            stamp=float(next(scans)),
            ranges=np.zeros(1),
            points=np.zeros((1, 3)),
            oTb=SE3.Identity(),
        )
    )
    recorded, kept = RecordedRobot(inner, busy), Kept()
    kept.thing = lambda field, number, thing: things.append((field, number, thing.stamp))
    recorded.record(kept)
    for turn in range(2):
        recorded.read()
        assert recorded.laser.latest(np.inf) is recorded.laser.latest(np.inf)
        assert recorded.laser.latest(np.inf).stamp == turn
    recorded.read()
    recorded.end()
    assert things == [("scan", 1, 0.0), ("scan", 2, 1.0)]
    assert [int(row["scan"]) for row in kept.rows] == [1, 2, -1]
