"""`bench obstacles` as a person calls it, and the motion that it judges."""

import json

import numpy as np
import pytest
from pinocchio import SE3
from typer.testing import CliRunner

from app.commands import app
from controller import OPEN_FLOOR, Command, PoseGoal, Surroundings
from lab.bench.configuration import Configuration
from lab.bench.evaluation import Failure, failure_of
from lab.bench.motion import run_motion
from lab.bench.obstacles import median_interval, world_names


def call(*arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of one command."""
    result = CliRunner().invoke(app, ["bench", "obstacles", *(str(a) for a in arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stdout, result.stderr


def test_a_row_for_every_robot_and_controller(tmp_path):
    file = tmp_path / "obstacles.json"
    code, out, _ = call("--count", 4, "--limit", 3, "--workers", 1, "--json", file)
    assert code == 0
    assert "furniture" in out
    kept = json.loads(file.read_text())
    assert kept["machine"]
    rows = kept["results"]
    assert [(row["robot"], row["controller"]) for row in rows] == [
        (robot, controller)
        for robot in ("frankie", "omni")
        for controller in ("frankie", "without guidance", "paper", "blind")
    ]
    for row in rows:
        assert row["all"]["worlds"] == 4
        assert list(row["families"]) == ["room", "shelf", "table", "walkers"]
        assert row["all"]["failures"] == sum(row["all"]["failures_by_reason"].values())
        assert [world["world"] for world in row["worlds"]] == [
            "room:0",
            "shelf:0",
            "table:0",
            "walkers:0",
        ]
        for world in row["worlds"]:
            assert bool(world["touches"]) == (world["clearance_mm"] < 0.0)


def test_the_same_figures_whatever_the_number_of_processes(tmp_path):
    rows = []
    options = ("--robot", "omni", "--controller", "frankie", "--family", "walkers", "--limit", 2)
    for workers in (1, 2):
        file = tmp_path / f"{workers}.json"
        assert call(*options, "--count", 7, "--workers", workers, "--json", file)[0] == 0
        rows.append(json.loads(file.read_text())["results"])
    assert rows[0] == rows[1]


def test_one_world_is_run_again_with_a_trace_and_a_picture(tmp_path):
    pytest.importorskip("matplotlib")
    options = ("--robot", "omni", "--controller", "frankie", "--limit", 2)
    code, out, _ = call(*options, "--only", "shelf:3", "--trace", "--plot", tmp_path)
    assert code == 0
    assert "omni, frankie, shelf:3" in out
    assert "0.20 |" in out
    assert (tmp_path / "omni-0-shelf-3.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--family", "shelv"), "shelf"),
        (("--controller", "papre"), "paper"),
        (("--only", "shelf"), "shelf:3"),
        (("--trace",), "--only"),
        (("--robot", "frank"), "frankie"),
    ],
)
def test_what_is_not_there_is_refused_in_one_line(arguments, message):
    code, _, err = call(*arguments)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1


def test_the_families_take_turns():
    names = world_names(6, ("room", "table"))
    assert names == [
        ("room", 0),
        ("table", 0),
        ("room", 1),
        ("table", 1),
        ("room", 2),
        ("table", 2),
    ]


def test_the_interval_of_a_median_holds_it_and_shrinks():
    rng = np.random.default_rng(1)
    few, many = (median_interval(list(rng.normal(1.0, 0.1, count))) for count in (20, 500))
    for median, low, high in (few, many):
        assert low <= median <= high
    assert many[2] - many[1] < few[2] - few[1]
    assert median_interval([]) is None


GOAL = PoseGoal(wTe=SE3(np.diag([1.0, -1.0, -1.0]), np.array([1.5, 0.5, 0.6])))


def moved(controller=None, **options):
    configuration = Configuration(robot="frankie", base_speed=1.0)
    model = configuration.model()
    controller = controller or configuration.controller(model)
    return run_motion(controller, model, lambda time: GOAL, period=0.01, limit=8.0, **options)


def test_a_robot_with_lag_starts_later_and_arrives_too():
    exact, late = moved(), moved(lag=True)
    assert exact.arrived
    assert late.arrived
    begun = (np.abs(motion.q[10] - motion.q[0]).max() for motion in (exact, late))
    assert next(begun) > 1.2 * next(begun) > 0.0


def test_the_controller_is_told_what_is_around_at_every_time():
    seen = []

    class Stops:
        def step(self, state, goal, last, surroundings=OPEN_FLOOR):
            seen.append(surroundings)
            return Command.stop(), Report(len(seen))

    class Report:
        solved = True

        def __init__(self, steps):
            self.unreachable = "too far" if steps == 5 else ""

    around = Surroundings()
    motion = moved(Stops(), surroundings_at=lambda time: around)
    assert seen == [around] * 5
    assert motion.unreachable == "too far"
    assert failure_of(motion) is Failure.UNREACHABLE
