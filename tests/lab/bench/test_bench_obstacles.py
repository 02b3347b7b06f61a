"""`bench obstacles`, and the motions that it judges."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from bench_call import refused, report
from pinocchio import SE3

from controller import Command, PoseGoal, Surroundings
from lab.bench.configuration import Configuration
from lab.bench.simulated_motion import run_motion

FAMILIES = ["room", "shelf", "table", "walkers"]


@pytest.mark.slow
def test_a_row_for_every_robot_and_controller(tmp_path):
    kept = report(tmp_path, "obstacles", "--count", 4, "--limit", 3, "--workers", 1)
    assert "furniture" in kept["stdout"]
    rows = [(row["robot"], row["controller"]) for row in kept["results"]]
    assert rows == list(product(("frankie", "omni"), ("frankie", "paper", "blind")))
    for row in kept["results"]:
        assert (row["all"]["worlds"], list(row["families"])) == (4, FAMILIES)
        assert row["all"]["failures"] == sum(row["all"]["failures_by_reason"].values())
        assert [world["world"] for world in row["worlds"]] == [f"{name}:0" for name in FAMILIES]
        for world in row["worlds"]:
            assert bool(world["touches"]) == (world["clearance_mm"] < 0.0)


def test_one_world_is_run_without_failure(tmp_path):
    options = ("--robot", "omni", "--controller", "frankie", "--only", "table:0", "--workers", 1)
    (row,) = report(tmp_path, "obstacles", *options)["results"]
    (world,) = row["worlds"]
    assert (world["world"], world["reason"], world["touches"]) == ("table:0", None, [])
    assert row["all"]["failures"] == 0
    assert row["all"]["time_ratio"] == pytest.approx(world["time_s"] / world["free_time_s"], 1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--controller", "papre"), "paper"),
        (("--only", "shelf"), "shelf:3"),
        (("--robot", "frank"), "frankie"),
    ],
)
def test_unknown_names_are_refused_in_one_line(arguments, message):
    refused(message, "obstacles", *arguments)


GOAL = PoseGoal(target=SE3(np.diag([1.0, -1.0, -1.0]), np.array([1.5, 0.5, 0.6])))


def moved(step=None, **options):
    configuration = Configuration(robot="frankie", base_speed=1.0)
    model = configuration.model()
    step = step or configuration.step(model)
    return run_motion(step, model, lambda time: GOAL, period=0.01, limit=8.0, **options)


def test_a_robot_with_lag_starts_later_and_arrives_too():
    exact, late = moved(), moved(lag=True)
    assert exact.arrived
    assert late.arrived
    begun = (np.abs(motion.q[10] - motion.q[0]).max() for motion in (exact, late))
    assert next(begun) > 1.2 * next(begun) > 0.0


def test_the_controller_is_given_the_obstacles_and_its_report_ends_the_motion():
    seen = []

    def stops(state, goal, last, surroundings):
        seen.append(surroundings)
        unreachable = "too far" if len(seen) == 5 else ""
        return Command.stop(7), SimpleNamespace(solved=True, unreachable=unreachable)

    around = Surroundings()
    assert moved(stops, surroundings_at=lambda time: around).unreachable == "too far"
    assert seen == [around] * 5
