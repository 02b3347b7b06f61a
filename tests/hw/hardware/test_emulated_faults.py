"""Faults of parts of the whole robot, and that it goes on after them."""

from __future__ import annotations

import time

import numpy as np
import pytest
from driven_robot import GO, has, healthy, tick, until
from emulated_robot import emulated, needs_drivers, robot_file

from hw import FaultKind, Gate, Refusal, WorldOptions, open_backend

pytestmark = [pytest.mark.realtime, needs_drivers]


def slow(*values):
    return pytest.param(*values, marks=pytest.mark.slow)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    path = robot_file(tmp_path_factory.mktemp("robots"))
    with emulated(path) as link:
        yield path, link


@pytest.fixture
def robot(place):
    backend = open_backend(str(place[0]), "kinematic", WorldOptions(scene="single", seed=1))
    with backend.robot as robot:
        robot.clock = backend.clock
        yield robot


@pytest.fixture
def gate(robot):
    return Gate(robot, robot.description, 0.01)


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        ("arm unplug 1.0", FaultKind.CONNECTION),
        slow("arm freeze 1.0", FaultKind.CONNECTION),
        slow("arm reflex", FaultKind.REFLEX),
        slow("break", FaultKind.CONNECTION),
        slow("blind 1.5", FaultKind.CONNECTION),
    ],
)
def test_the_loop_lives_through_a_fault_and_moves_again(robot, gate, place, words, kind):
    """No reading is disbelieved for so long that the run would end: the tree gets its chance."""
    until(robot, gate, lambda state: state.base_twist[0] > 0.05, command=GO)
    place[1].do(words)
    until(robot, gate, has(kind), command=GO)
    assert gate.judge(robot.read(), robot.clock.now()) in (Refusal.FAULT, Refusal.READING)
    until(robot, gate, lambda state: not np.abs(state.qd).max() > 0.01)
    time.sleep(1.0)
    robot.recover()
    until(robot, gate, healthy)
    until(robot, gate, lambda state: state.base_twist[0] > 0.05, command=GO)
    until(robot, gate, lambda state: state.qd[5] > 0.1, command=GO)


@pytest.mark.slow
@pytest.mark.parametrize(("words", "clearable"), [("freeze", True), ("lost", False)])
def test_a_base_that_does_not_tell_where_it_is_stops_both(robot, gate, place, words, clearable):
    until(robot, gate, lambda state: state.base_twist[0] > 0.05, command=GO)
    place[1].do(f"{words} yes")
    state = until(robot, gate, has(FaultKind.STALE_POSE), command=GO)
    assert [one.clearable for one in state.faults if one.kind is FaultKind.STALE_POSE] == [
        clearable
    ]
    until(robot, gate, lambda state: not np.abs(state.qd).max() > 0.01)
    place[1].do(f"{words} no")
    time.sleep(1.0)
    robot.recover()
    until(robot, gate, healthy)
    until(robot, gate, lambda state: state.base_twist[0] > 0.05, command=GO)


def test_the_emergency_stop_of_the_cell_stops_both_and_is_latched(robot, gate, place):
    until(robot, gate, lambda state: state.base_twist[0] > 0.05, command=GO)
    place[1].do("stop")
    until(robot, gate, has(FaultKind.EMERGENCY_STOP), command=GO)
    until(robot, gate, lambda state: not np.abs((*state.qd, *state.base_twist)).max() > 0.01)
    place[1].do("release")
    until(robot, gate, lambda state: not has(FaultKind.EMERGENCY_STOP)(state))
    robot.recover()
    until(robot, gate, healthy)
    assert tick(robot, gate, GO)[1] is Refusal.EMERGENCY_STOP
    gate.acknowledge()
    until(robot, gate, lambda state: state.base_twist[0] > 0.05, command=GO)
