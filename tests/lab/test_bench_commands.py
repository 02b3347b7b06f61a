"""The benches as a person calls them."""

import json
from importlib import import_module

import numpy as np
import pytest
from typer.testing import CliRunner

from app.commands import app
from lab.bench import plots, published
from lab.shared import workers


def call(*arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of one command."""
    result = CliRunner().invoke(app, ["bench", *(str(argument) for argument in arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.stdout, result.stderr


def refused(message: str, *arguments: object) -> None:
    """The command ends with exit code 2 and one line that contains this message."""
    code, _, err = call(*arguments)
    assert code == 2
    assert message in err
    assert err.count("\n") == 1
    assert "Traceback" not in err


def without(monkeypatch, module, missing: str) -> None:
    """A package is not installed, as far as a module can tell."""

    def find(name: str):
        if name.split(".")[0] == missing:
            raise ModuleNotFoundError(f"No module named {name!r}", name=missing)
        return import_module(name)

    monkeypatch.setattr(module, "import_module", find)


# reach

WANTED = {
    "goals",
    "failures",
    "failures_by_reason",
    "limit_violations",
    "contact_samples",
    "time_median_s",
    "time_p95_s",
    "time_max_s",
    "theta_eps_mean_deg",
    "manipulability_mean",
}


def test_reach_counts_what_happened_on_the_way_to_every_goal(tmp_path):
    file = tmp_path / "reach.json"
    code, out, _ = call("reach", "--count", 4, "--base-speed", 1.0, "--workers", 1, "--json", file)
    assert code == 0
    assert "Experiment 2" in out
    kept = json.loads(file.read_text())
    assert kept["seed"] == 0
    assert kept["machine"]
    assert [(row["robot"], row["base_speed"]) for row in kept["results"]] == [
        ("frankie", 1.0),
        ("omni", 1.0),
    ]
    for row in kept["results"]:
        assert set(row) >= WANTED
        assert row["goals"] == 4
        assert row["failures"] == sum(row["failures_by_reason"].values()) == 0
        assert row["limit_violations"] == 0
        assert row["contact_samples"] == 0
        assert 0.5 < row["time_median_s"] <= row["time_p95_s"] <= row["time_max_s"] <= 20.0
        assert 0.0 < row["manipulability_mean"] < 0.2


def test_reach_gives_the_same_figures_whatever_the_number_of_processes(tmp_path):
    rows = []
    for processes in (1, 2):
        file = tmp_path / f"{processes}.json"
        common = ("--robot", "omni", "--count", 7, "--base-speed", 1.5, "--limit", 1.0)
        assert call("reach", *common, "--workers", processes, "--json", file)[0] == 0
        rows.append(json.loads(file.read_text()))
    assert rows[0] == rows[1]


def test_reach_takes_goals_from_a_file_and_says_why_one_failed(tmp_path):
    T = np.tile(np.eye(4), (2, 1, 1))
    T[0] = np.diag([1.0, -1.0, -1.0, 1.0])
    T[0, :3, 3] = [0.63, 0.0, 0.75]
    T[1, :3, 3] = [0.0, 0.0, 9.0]
    np.savez(tmp_path / "goals.npz", T=T)
    file = tmp_path / "reach.json"
    options = ("--robot", "frankie", "--base-speed", 1.0, "--limit", 2, "--workers", 1)
    call("reach", *options, "--goals", tmp_path / "goals.npz", "--json", file)
    (row,) = json.loads(file.read_text())["results"]
    assert (row["goals"], row["failures"], row["failed_goals"]) == (2, 1, [1])


def test_a_sweep_has_a_row_for_every_value_and_changes_the_outcome(tmp_path):
    file = tmp_path / "sweep.json"
    options = ("--preset", "paper", "--robot", "frankie", "--count", 2, "--limit", 2)
    code, _, _ = call("reach", *options, "--workers", 1, "--sweep", "heading", "--json", file)
    assert code == 0
    rows = json.loads(file.read_text())["results"]
    assert [row["changes"] for row in rows] == [
        {"heading_gain": gain} for gain in (0.0, 0.1, 0.5, 1.0)
    ]
    assert len({row["theta_eps_mean_deg"] for row in rows}) == 4


def test_bad_goals_and_folders_are_refused_in_one_line(tmp_path):
    refused("none.npz", "reach", "--goals", tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("hello")
    refused("not a readable .npz", "reach", "--goals", tmp_path / "text.npz")
    for command in ("reach", "poses", "step"):
        refused("cannot be written", command, "--json", tmp_path / "no" / "file")


def test_a_cluster_needs_its_extra(monkeypatch):
    without(monkeypatch, workers, "distributed")
    options = ("--count", 1, "--robot", "omni", "--cluster", "tcp://127.0.0.1:1")
    refused('pip install "frankie-task[cluster]"', "reach", *options)


@pytest.mark.parametrize(
    "options",
    [
        ("--starts", "limits"),
        ("--starts", "stretched", "--goals", "above"),
        ("--starts", "singular", "--noise", "--goals", "near"),
        ("--starts", "random", "--delay-ms", 30, "--goals", "floor"),
    ],
)
def test_reach_starts_elsewhere_and_disturbs_the_robot(tmp_path, options):
    file = tmp_path / "reach.json"
    common = ("--robot", "frankie", "--base-speed", 1.0, "--count", 2, "--workers", 1)
    assert call("reach", *common, *options, "--json", file)[0] == 0
    (row,) = json.loads(file.read_text())["results"]
    assert (row["failures"], row["limit_violations"], row["contact_samples"]) == (0, 0, 0)


def test_reach_says_how_fast_the_base_drives_backwards(tmp_path):
    times = []
    for speed in (0.1, 1.0):
        file = tmp_path / "reach.json"
        options = ("--robot", "omni", "--base-speed", 1.0, "--reverse-speed", speed)
        call("reach", *options, "--count", 4, "--workers", 1, "--json", file)
        (row,) = json.loads(file.read_text())["results"]
        assert row["reverse_speed"] == speed
        times.append(row["time_mean_s"])
    assert times[0] > times[1]


def test_an_unknown_start_is_refused():
    refused("stretched", "reach", "--starts", "streched", "--count", 1)


# poses


def test_poses_reports_times_beside_those_of_the_paper(tmp_path):
    file = tmp_path / "poses.json"
    code, out, _ = call("poses", "--robot", "frankie", "--pose", "a", "--json", file)
    assert code == 0
    assert "5.42" in out
    (row,) = json.loads(file.read_text())["results"]
    assert row["pose"] == "a"
    assert row["time_s"] < row["paper_time_s"]
    assert row["position_error_mm"] <= 10.0
    assert row["limit_violations"] == 0
    assert row["contact_samples"] == 0
    assert row["jerk_noise"] < 1e-3 * row["jerk"]


def test_pictures_are_drawn_if_matplotlib_is_there(tmp_path):
    pytest.importorskip("matplotlib")
    options = ("--robot", "omni", "--pose", "a", "--plot", tmp_path / "plots")
    assert call("poses", *options)[0] == 0
    files = sorted((tmp_path / "plots").glob("*.png"))
    assert [file.name for file in files] == [
        "omni-frankie-1.5-above.png",
        "omni-frankie-1.5-curves.png",
    ]
    assert all(file.stat().st_size > 10_000 for file in files)


def test_pictures_need_their_extra(monkeypatch, tmp_path):
    without(monkeypatch, plots, "matplotlib")
    refused('pip install "frankie-task[plots]"', "poses", "--plot", tmp_path / "plots")


def test_an_unknown_pose_is_refused():
    refused("a, b, c, d", "poses", "--pose", "e")


# step


def test_step_times_the_presets_and_their_parts(tmp_path):
    file = tmp_path / "step.json"
    code, out, _ = call("step", "--robot", "frankie", "--steps", 30, "--json", file)
    assert code == 0
    assert "parts of a step" in out
    (row,) = json.loads(file.read_text())["results"]
    assert [timing["name"] for timing in row["timings"]] == ["frankie", "paper"]
    assert [timing["name"] for timing in row["near"]] == [
        "15 to 25 pairs near",
        "the same, nothing near",
    ]
    assert row["ratios"]["frankie / paper"] > 0.0
    assert "processor time: 15 to 25 pairs near / the same, nothing near = " in out
    for timing in row["timings"]:
        assert timing["steps"] >= 30
        assert 0.0 < timing["median"] <= timing["p95"] <= timing["p99"] <= timing["worst"]
    assert min(row["parts"].values()) > 0.0
    assert row["agreement"] is None


def test_the_toolbox_must_be_installed(monkeypatch):
    without(monkeypatch, published, "roboticstoolbox")
    refused("pip install roboticstoolbox-python", "step", "--vs", "rtb", "--steps", 10)


@pytest.mark.slow
def test_the_paper_preset_agrees_with_the_published_example(tmp_path):
    for package in ("roboticstoolbox", "qpsolvers", "quadprog"):
        pytest.importorskip(package)
    file = tmp_path / "step.json"
    assert call("step", "--vs", "rtb", "--steps", 1000, "--json", file)[0] == 0
    for row in json.loads(file.read_text())["results"]:
        assert row["agreement"] < 1e-5


@pytest.mark.slow
def test_a_cluster_gives_the_same_figures_as_this_computer(tmp_path):
    distributed = pytest.importorskip("distributed")
    common = ("--robot", "omni", "--count", 7, "--base-speed", 1.5, "--limit", 1.0)
    here, there = tmp_path / "here.json", tmp_path / "there.json"
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(processes=False, **options) as cluster:
        address = cluster.scheduler_address
        assert call("reach", *common, "--cluster", address, "--json", there)[0] == 0
    assert call("reach", *common, "--workers", 1, "--json", here)[0] == 0
    assert json.loads(here.read_text()) == json.loads(there.read_text())


# tree


def test_tree_times_reading_and_ticking(tmp_path):
    path = tmp_path / "tree.json"
    code, out, _ = call("tree", "--rounds", 2, "--json", path)
    assert code == 0
    assert "200 nodes" in out
    assert "31 nodes" in out
    read, tick = json.loads(path.read_text())["results"]
    assert (read["steps"], tick["steps"]) == (2, 200)
    assert 0.0 < tick["median"] < read["median"]
