"""The fault matrix: its judge and its counts."""

from types import SimpleNamespace

import numpy as np
import pytest
from bench_call import refused, report
from harness import Harness, driving, looking_down

from controller import Command, PoseGoal
from extensions.faults import INJECTABLE
from hw import Backend, SimClock
from lab.bench import faults
from lab.bench.faults import Cell, faults_notes
from lab.bench.witness import Witness

CARRY = Cell(fault="frames lost", phase="carry", seed=1)


@pytest.mark.slow
def test_a_fault_that_harms_nothing_leaves_a_clean_row():
    carried = faults.run_cell(CARRY)
    assert carried.injected_s is not None
    assert (carried.outcome, carried.exit_code) == ("success", 0)
    assert carried.violations == carried.lost == 0
    assert not any((carried.wrong_success, carried.hang, carried.crash, carried.moving))
    assert faults_notes([carried]) == []


@pytest.mark.slow
def test_an_object_that_is_not_where_the_tree_says_is_a_wrong_success(monkeypatch):
    monkeypatch.setattr(faults, "_GOAL", "another table")
    result = faults.run_cell(CARRY)
    assert result.outcome == "success"
    assert result.wrong_success
    assert "wrong success" in faults_notes([result])[0]


def test_an_exception_instead_of_an_outcome_is_a_crash(monkeypatch):
    def run_task(options, *, interrupted, instruments):
        instruments.opened(Backend(robot=Harness().robot, clock=SimClock(), truth=None))
        raise OSError("no outcome")

    monkeypatch.setattr(faults, "run_task", run_task)
    result = faults.run_cell(CARRY)
    assert result.crash
    assert result.reason == "OSError: no outcome"


def test_a_run_that_takes_too_long_hangs(monkeypatch, tmp_path):
    monkeypatch.setattr(faults, "LONGEST", 2.0)
    chosen = ("--faults", "reflex", "--phases", "recover", "--workers", 1)
    kept = report(tmp_path, "faults", *chosen)
    (cell,) = kept["cells"]
    assert (cell["fault"], cell["phase"], cell["outcome"]) == ("reflex", "recover", "hang")
    assert cell["hang"]
    assert cell["duration_s"] < 4.0
    assert "1 hang" in kept["stdout"]
    assert "reflex in recover, seed 1: hang" in kept["stdout"]


def test_what_breaks_the_solver_reaches_it():
    """Only while it lasts."""
    harness, by_name = Harness(), {fault.name: fault for fault in faults.FAULTS}
    setup, state = SimpleNamespace(controller=harness.controller), harness.robot.read()
    goal = PoseGoal(target=looking_down(1.0, 0.0, 0.8))
    undo = by_name["solver gives up"].begin(setup, [])
    assert not harness.step(state, goal).solved
    undo()
    assert harness.step(state, goal).solved
    by_name["solver raises"].begin(setup, [])
    with pytest.raises(ArithmeticError, match="injected"):
        harness.step(state, goal)


def test_unknown_names_are_refused_with_a_suggestion():
    refused("did you mean `reflex`?", "faults", "--faults", "reflx")
    refused("did you mean `descend`?", "faults", "--phases", "decend")


def test_the_matrix_has_every_fault_that_can_be_injected():
    """But for what people do: see `bench untruth`."""
    people = {"object pulled", "object given"}
    assert {fault.name for fault in faults.FAULTS} >= set(INJECTABLE) - people


def sent(*commands: Command) -> Witness:
    harness = Harness()
    witness = Witness(harness.robot)
    for number, command in enumerate(commands):
        harness.clock.sleep_until(0.01 * number)
        witness.read()
        witness.send(command)
    return witness


def driven(*speeds: float) -> Witness:
    """A robot that got these speeds, one a period."""
    return sent(*map(driving, speeds))


def test_the_witness_counts_what_changes_too_fast():
    limit = 0.01 * Harness().robot.description.limits.base_acceleration[0]
    assert driven(0.0, limit, 2 * limit, 3 * limit).violations == 0
    assert driven(0.0, limit, 10 * limit).violations == 1
    assert driven(limit, 2 * limit, -10 * limit).violations == 1


def test_the_witness_counts_what_is_too_fast_and_out_of_range():
    for joint, speed, readings in ((0, 3.0, 40), (6, 1.0, 400)):
        turning = Command(base_twist=np.zeros(3), qd=speed * np.eye(7)[joint])
        assert sent(*[turning] * readings).violations > 2
