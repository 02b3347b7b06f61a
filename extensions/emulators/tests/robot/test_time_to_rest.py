"""Whatever goes wrong with the whole robot: base and arm are told to rest within 0.25 s.

The emulators keep since when each is told to rest. `pytest -rP` shows the times; those of
docs/hardware.md were measured so, with `-m "slow or not slow"`.
"""

import time

import numpy as np
import pytest
from emulated_panda import IN_TIME
from emulated_robot import emulated, needs_drivers, robot_file

from controller import Command
from hw import Gate, Refusal, WorldOptions, open_backend
from hw.clock import stopwatch

pytestmark = [
    pytest.mark.realtime,
    needs_drivers,
    pytest.mark.slow,
    pytest.mark.skipif(not IN_TIME, reason="the system grants no real-time priority"),
]
GO = Command(base_twist=np.array([0.3, 0.0, 0.0]), qd=0.4 * np.array([1.0, 0, 0, 0, 0, 1.0, 0]))
"""A brisk motion of both."""
LONGEST = 0.25
"""From the last good command until both are told to rest [s]."""
WATCHED = 1.2
"""After the event [s]."""
STOPS = {
    "arm reflex": "",
    "arm stop": "arm release",
    "arm lock": "arm release",
    "arm guide": "arm release",
    "arm freeze 1.5": "",
    "arm unplug 1.5": "",
    "arm drop 1": "arm drop 0",
    "arm delay 1 0.05": "arm delay 0",
    "stop": "release",
    "lost yes": "lost no",
    "dock": "undock",
    "freeze yes": "freeze no",
    "break": "",
    "blind 1.5": "",
    "stare yes": "stare no",
}
"""What stops the robot, and what ends it."""
GOES_ON = {"delay 0.01 0.005": "delay 0", "noise yes": "noise no", "arm drop 0.01": "arm drop 0"}
"""What it is to live through."""


def tick(robot, gate, command=None):
    """One turn of a loop; the reading, and why it allows no motion."""
    state, now = robot.read(), robot.clock.now()
    refusal = gate.judge(state, now)
    if refusal is Refusal.READING:
        gate.send(gate.applied, state, now)
    elif command is None or refusal is not None:
        gate.brake(state, now)
    else:
        last = gate.continue_from(state, now)
        gate.send(_towards(last, command, robot.description.limits), state, robot.clock.now())
    time.sleep(0.01)
    return state, refusal


def _towards(last, command, limits):
    step, steps = limits.base_acceleration * 0.01, limits.qdd * 0.01
    return Command(
        base_twist=last.base_twist + np.clip(command.base_twist - last.base_twist, -step, step),
        qd=last.qd + np.clip(command.qd - last.qd, -steps, steps),
    )


def until(robot, gate, done, command=None, patience=60.0):
    """The first reading of which something is true."""
    end = robot.clock.now() + patience
    while robot.clock.now() < end:
        state, refusal = tick(robot, gate, command)
        if done(state):
            return state
    raise AssertionError(f"not within {patience:g} s: {state.faults}, {refusal}")


def healthy(state) -> bool:
    return not (state.faults or state.recovering)


def go_on(robot, gate, seconds, command) -> float:
    """Want a motion for a while; when the last command was given that moves [s]."""
    given, end = 0.0, stopwatch() + seconds
    while stopwatch() < end:
        now = stopwatch()
        if tick(robot, gate, command)[1] is None:
            given = now
    return given


@pytest.fixture(scope="module")
def stand(tmp_path_factory):
    """The link to the emulators, and the robot."""
    path = robot_file(tmp_path_factory.mktemp("robots"))
    with emulated(path, "single") as link:
        backend = open_backend(str(path), "kinematic", WorldOptions(scene="single", seed=1))
        with backend.robot as robot:
            robot.clock, robot.start = backend.clock, robot.read()
            yield link, robot


@pytest.fixture
def gate(stand):
    """Healthy, and back where it was."""
    _, robot = stand
    gate = Gate(robot, robot.description, 0.01)
    end = stopwatch() + 60.0
    while not healthy(state := robot.read()):
        assert stopwatch() < end, state.faults
        robot.recover()  # again, if what has stopped it came back
        again = stopwatch() + 10.0
        while stopwatch() < again and not healthy(tick(robot, gate)[0]):
            pass
    gate.acknowledge()
    for _ in range(500):
        state = tick(robot, gate, back(robot.read(), robot.start))[0]
        if not back(state, robot.start).base_twist.any() and max(abs(state.qd)) < 0.01:
            break
    go_on(robot, gate, 0.3, None)
    return gate


def back(state, start) -> Command:
    """Towards where the robot was at first."""
    v = -0.2 if (start.oTb.inverse() * state.oTb).translation[0] > 0.03 else 0.0
    return Command(
        base_twist=np.array([v, 0.0, 0.0]), qd=np.clip(3.0 * (start.q - state.q), -0.5, 0.5)
    )


def set_off(robot, gate) -> None:
    """Both move nearly as fast as they are wanted to."""
    until(
        robot,
        gate,
        lambda state: state.base_twist[0] > 0.25 and min(state.qd[0], state.qd[5]) > 0.35,
        GO,
    )


def rests(link) -> tuple[float, float]:
    """When base and arm were told to rest, by the emulators [s]."""
    asked = stopwatch()
    base, arm = link.do("tell"), link.do("arm tell")
    assert base["still"] > 0.0, "the base is told to move"
    assert arm["still"] > 0.0, "the arm is told to move"
    assert stopwatch() - asked < 0.05
    return base["stamp"] - base["still"], arm["now"] - arm["still"]


@pytest.mark.parametrize("words", STOPS)
def test_a_fault_of_one_part_stops_both_in_time(stand, gate, words):
    link, robot = stand
    set_off(robot, gate)
    event = stopwatch()
    link.do(words)
    given = go_on(robot, gate, WATCHED, GO)
    base, arm = rests(link)
    time.sleep(0.5)
    if STOPS[words]:
        link.do(STOPS[words])
    time.sleep(0.3)
    last = max(given, event)
    times = base - event, arm - event, last - event, max(base, arm) - last
    row = " | ".join([words, *(f"{one:.2f}" for one in times)])  # of the table in docs/hardware.md
    print(row)
    assert max(base, arm) - last < LONGEST, row
    if words in ("freeze yes", "break"):  # of good commands it has heard nothing since
        assert base - event < LONGEST, row


@pytest.mark.parametrize("words", GOES_ON)
def test_what_happens_every_day_stops_nothing(stand, gate, words):
    link, robot = stand
    set_off(robot, gate)
    link.do(words)
    given = go_on(robot, gate, WATCHED, GO)
    assert stopwatch() - given < 0.05
    base, arm = link.do("tell"), link.do("arm tell")
    link.do(GOES_ON[words])
    assert base["still"] < 0.05
    assert arm["still"] == 0.0
    assert arm["violations"] == []
