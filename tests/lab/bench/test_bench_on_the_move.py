"""`bench on-the-move` delivers the same objects both ways, and reports the time saved."""

import pytest
from bench_call import report

from lab.bench.on_the_move import Passing, saving


def run(way: str, seed: int, seconds: float, delivered: bool = True) -> Passing:
    ends = {"delivered": delivered, "first": delivered, "contacts": 0, "limit_violations": 0}
    return Passing(way=way, seed=seed, seconds=seconds, **ends)


@pytest.mark.slow
def test_both_ways_deliver_a_real_object_to_the_table(tmp_path):
    options = ("--seeds", "101", "--workers", 1, "--record", tmp_path / "runs")
    kept = report(tmp_path, "on-the-move", *options)
    assert [one["way"] for one in kept["results"]] == ["standing", "in_passing"]
    for of_way, one in zip(kept["ways"], kept["results"], strict=True):
        assert one["delivered"]
        assert one["first"]
        assert one["contacts"] == one["limit_violations"] == 0
        assert 8.0 < one["seconds"] < 20.0
        assert of_way["way"] == one["way"]
        assert of_way["runs"] == of_way["delivered"] == of_way["first"] == 1
        assert of_way["time_mean_s"] == one["seconds"]
    before, after = (one["seconds"] for one in kept["results"])
    assert kept["saving"]["share"] == pytest.approx(1.0 - after / before)
    assert "of the time, over 1 objects" in kept["stdout"]


def test_a_saving_is_over_the_objects_that_both_ways_delivered():
    runs = [run("standing", seed, 10.0 + seed) for seed in range(4)]
    runs += [run("in_passing", seed, 5.0 + seed) for seed in range(3)]
    runs.append(run("in_passing", 3, 1.0, delivered=False))
    saved = saving(runs)
    assert saved.pairs == 3
    assert saved.share == pytest.approx(5.0 / 11.0)
    assert saved.interval == pytest.approx((5.0 / 11.0, 5.0 / 11.0))
    assert saving(runs[:4]) is None
