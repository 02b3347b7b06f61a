"""The bench of faults judges on the truth, and what it counts as wrong can happen."""

import json
from dataclasses import replace

import numpy as np
import pytest
from harness import Harness
from typer.testing import CliRunner

import lab.bench.faults as bench_faults
from app.commands import app
from controller import Command
from hw import INJECTABLE
from lab import bench
from lab.bench.witness import Witness

CARRY = bench.Cell(trouble="frames lost", phase="carry", seed=1)


def call(*arguments: object):
    return CliRunner().invoke(app, ["bench", "faults", *map(str, arguments)])


@pytest.fixture(scope="module")
def carried() -> bench.CellResult:
    return bench_faults.run_cell(CARRY)


def test_a_fault_that_harms_nothing_leaves_a_clean_row(carried):
    assert carried.injected_s is not None
    assert (carried.outcome, carried.exit_code) == ("success", 0)
    assert carried.violations.total == carried.lost == 0
    assert not any((carried.wrong_success, carried.hang, carried.crash, carried.moving))
    assert bench.faults_notes([carried]) == []


def test_an_object_that_is_not_where_the_tree_says_is_a_wrong_success(monkeypatch):
    monkeypatch.setattr(bench_faults, "GOAL", "another table")
    result = bench_faults.run_cell(CARRY)
    assert result.outcome == "success"
    assert result.wrong_success
    assert "wrong success" in bench.faults_notes([result])[0]


def test_a_run_that_takes_too_long_hangs(monkeypatch):
    monkeypatch.setattr(bench_faults, "LONGEST", 1.0)
    result = bench_faults.run_cell(CARRY)
    assert result.hang
    assert result.outcome == "hang"
    assert result.duration_s < 3.0


def test_an_exception_instead_of_an_outcome_is_a_crash(monkeypatch):
    def run_task(options, *, interrupted, instruments):
        instruments.beneath(Harness().robot)
        raise OSError("no outcome")

    monkeypatch.setattr(bench_faults, "run_task", run_task)
    result = bench_faults.run_cell(CARRY)
    assert result.crash
    assert result.reason == "OSError: no outcome"


def test_sums_and_json_one_row_a_cell(carried, monkeypatch, tmp_path):
    def run_cell(cell: bench.Cell) -> bench.CellResult:
        return replace(carried, trouble=cell.trouble, phase=cell.phase, wrong_success=True)

    monkeypatch.setattr(bench_faults, "run_cell", run_cell)
    path = tmp_path / "cells.json"
    chosen = ("--faults", "frames lost", "--faults", "reflex", "--phases", "carry")
    result = call(*chosen, "--workers", 1, "--json", path)
    assert result.exit_code == 0, result.output
    cells = json.loads(path.read_text())["cells"]
    assert [(one["trouble"], one["phase"]) for one in cells] == [
        ("frames lost", "carry"),
        ("reflex", "carry"),
    ]
    assert "2 success" in result.stdout
    assert result.stdout.count("wrong success (") == 2


def test_unknown_names_are_refused_with_a_suggestion():
    assert "did you mean `reflex`?" in call("--faults", "reflx").stderr
    assert "did you mean `descend`?" in call("--phases", "decend").stderr


def test_the_matrix_has_every_fault_of_the_table():
    assert {trouble.name for trouble in bench_faults.TROUBLES} >= set(INJECTABLE)


def driving(speed: float) -> Command:
    return Command(base_twist=np.array([speed, 0.0, 0.0]), qd=np.zeros(7))


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
    assert driven(0.0, limit, 2 * limit, 3 * limit).violations.total == 0
    assert driven(0.0, limit, 10 * limit).violations.acceleration == 1
    assert driven(limit, 2 * limit, -10 * limit).violations.acceleration == 1


def test_the_witness_counts_what_is_too_fast_and_out_of_range():
    harness = Harness()
    witness = Witness(harness.robot)
    for number in range(400):
        harness.clock.sleep_until(0.01 * number)
        witness.read()
        witness.send(Command(base_twist=np.zeros(3), qd=np.array([1.0, *np.zeros(5), 3.0])))
    assert witness.violations.position > 0
    assert witness.violations.velocity > 0
