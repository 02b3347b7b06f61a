"""The soak carries objects, gives the task faults, and counts what became of both."""

import json

import pytest
from typer.testing import CliRunner

from app.commands import app
from hw import INJECTABLE
from lab import bench
from lab.bench.soak import LONGEST_S


@pytest.mark.slow
def test_a_soak_of_a_minute_accounts_for_every_object():
    told: list[float] = []
    soak = bench.run_soak(1.2 / 60.0, seed=3, progress=lambda soak: told.append(soak.hours))
    assert soak.hours == pytest.approx(1.2 / 60.0, abs=1e-3)
    assert soak.runs == 1
    assert soak.carried >= 2
    assert sum(soak.faults.values()) == 1
    assert soak.unaccounted == 0
    assert soak.violations.total == 0
    assert len(told) == len(soak.samples) == 2
    assert json.loads(bench.soak_json(soak))["soak"]["faults"] == soak.faults


def test_the_faults_of_the_soak_are_in_the_table():
    assert set(LONGEST_S) <= set(INJECTABLE)


@pytest.mark.slow
def test_the_command_prints_and_writes_what_came_of_it(tmp_path):
    path = tmp_path / "soak.json"
    result = CliRunner().invoke(app, ["bench", "soak", "--hours", "0.1", "--json", str(path)])
    assert result.exit_code == 0, result.output
    assert "not accounted for" in result.stdout
    soak = json.loads(path.read_text())["soak"]
    assert sum(soak["faults"].values()) == 6
