"""The fault matrix: its judge and its counts."""

from importlib.util import find_spec

import numpy as np
import pytest
from bench_call import refused, report
from faulty_robot import driving
from harness import Harness

from controller import Command
from hw import INJECTABLE
from lab.bench import faults
from lab.bench.fault_matrix import Fault
from lab.bench.faults import Cell, faults_notes
from lab.bench.witness import Witness

WORLDS = ("kinematic", "physics") if find_spec("mujoco") else ("kinematic",)
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
    elsewhere = Fault(name=CARRY.fault, duration=3.0, goal="another table")
    monkeypatch.setattr(faults, "FAULTS", (elsewhere,))
    result = faults.run_cell(CARRY)
    assert result.outcome == "success"
    assert result.wrong_success
    assert "wrong success" in faults_notes([result])[0]


@pytest.mark.slow
@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("fault", [one for one in faults.FAULTS if one.phase], ids=lambda f: f.name)
def test_what_a_person_does_to_a_lesson_ends_honestly(fault, world):
    seed = 1 + (fault.name == "nobody takes")  # in physics the mug of seed 1 slips out, and falls
    (cell,) = faults.cells([fault.name], ["carry"], [seed], world)
    result = faults.run_cell(cell)
    assert result.outcome == ("failure" if fault.goal is None else "success")
    assert faults_notes([result]) == []


def test_an_exception_instead_of_an_outcome_is_a_crash(monkeypatch):
    def run_task(options, *, interrupted, instruments):
        instruments.beneath(Harness().robot)
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


def test_unknown_names_are_refused_with_a_suggestion():
    refused("did you mean `reflex`?", "faults", "--faults", "reflx")
    refused("did you mean `descend`?", "faults", "--phases", "decend")


def test_the_matrix_has_every_fault_that_can_be_injected():
    assert {fault.name for fault in faults.FAULTS} >= set(INJECTABLE)


def driven(*speeds: float) -> Witness:
    """A robot that got these speeds, one a period."""
    harness = Harness()
    witness = Witness(harness.robot)
    for number, speed in enumerate(speeds):
        harness.clock.sleep_until(0.01 * number)
        witness.read()
        witness.send(driving(speed))
    return witness


def test_the_witness_counts_what_changes_too_fast():
    limit = 0.01 * Harness().robot.description.limits.base_acceleration[0]
    assert driven(0.0, limit, 2 * limit, 3 * limit).violations == 0
    assert driven(0.0, limit, 10 * limit).violations == 1
    assert driven(limit, 2 * limit, -10 * limit).violations == 1


def test_the_witness_counts_what_is_too_fast_and_out_of_range():
    for joint, speed, readings in ((0, 3.0, 40), (6, 1.0, 400)):
        harness, qd = Harness(), np.zeros(7)
        witness, qd[joint] = Witness(harness.robot), speed
        for number in range(readings):
            harness.clock.sleep_until(0.01 * number)
            witness.read()
            witness.send(Command(base_twist=np.zeros(3), qd=qd))
        assert witness.violations > 2
