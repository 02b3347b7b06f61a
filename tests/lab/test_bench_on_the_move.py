"""`bench on-the-move` carries the same object both ways, and tells what passing saves."""

import json

import pytest
from typer.testing import CliRunner

from app.commands import app
from lab.bench import saving
from lab.bench.on_the_move import Passing


def run(way: str, seed: int, seconds: float, brought: bool = True) -> Passing:
    return Passing(
        way=way,
        seed=seed,
        brought=brought,
        first=brought,
        seconds=seconds,
        contacts=0,
        limit_violations=0,
    )


def test_both_ways_bring_a_real_object_to_the_table(tmp_path):
    figures = tmp_path / "figures.json"
    options = ["--seeds", "101", "--workers", "1", "--record", str(tmp_path / "runs")]
    command = ["bench", "on-the-move", *options, "--json", str(figures)]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    report = json.loads(figures.read_text())
    assert [one["way"] for one in report["results"]] == ["standing", "in_passing"]
    for one in report["results"]:
        assert one["brought"]
        assert one["first"]
        assert one["contacts"] == one["limit_violations"] == 0
        assert 8.0 < one["seconds"] < 20.0
    for of_way, one in zip(report["ways"], report["results"], strict=True):
        assert of_way["way"] == one["way"]
        assert of_way["runs"] == of_way["brought"] == of_way["first"] == 1
        assert of_way["time_mean_s"] == one["seconds"]
    before, after = (one["seconds"] for one in report["results"])
    assert report["saving"]["share"] == pytest.approx(1.0 - after / before)
    assert "of the time, over 1 objects" in result.stdout


def test_a_saving_is_over_the_objects_that_both_ways_brought():
    runs = [run("standing", seed, 10.0 + seed) for seed in range(4)]
    runs += [run("in_passing", seed, 5.0 + seed) for seed in range(3)]
    runs.append(run("in_passing", 3, 1.0, brought=False))
    saved = saving(runs)
    assert saved is not None
    assert saved.pairs == 3
    assert saved.share == pytest.approx(5.0 / 11.0)
    assert saved.interval == pytest.approx((5.0 / 11.0, 5.0 / 11.0))
    assert saving(runs[:4]) is None
