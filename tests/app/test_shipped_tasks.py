"""The shipped tasks from beginning to end, with everything in the loop the real thing."""

import json
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader
from typer.testing import CliRunner

from app.cli import app


def run(record: Path, *arguments: object) -> tuple[int, dict, Path]:
    """Exit code, summary and folder of a run."""
    command = ["run", *map(str, arguments), "--record", str(record), "--json"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code in (0, 1), result.output
    (folder,) = record.iterdir()
    return result.exit_code, json.loads(result.stdout), folder


@pytest.fixture(scope="module")
def one_object(tmp_path_factory):
    """`pick_one` in the scene with a single object; run once for all tests of this file."""
    return run(tmp_path_factory.mktemp("one"), "pick_one", "--scene", "single", "--seed", 1)


def test_a_single_object_is_brought_to_the_table(one_object):
    code, summary, _ = one_object
    assert code == 0
    assert summary["outcome"] == "success"
    assert (summary["placed"], summary["objects"]) == (1, 1)
    assert summary["attempts"] >= 1
    assert 0.5 < summary["grasp_time_mean_s"] < summary["pick_place_time_mean_s"] < 60.0


def test_no_limit_is_passed_and_no_command_refused(one_object):
    _, summary, folder = one_object
    assert summary["limit_violations"] == 0
    assert summary["refused_commands"] == {}
    assert summary["highest_speed_percent"] <= 100.0
    commands = np.load(folder / "commands.npy")
    steps = np.diff(commands[:, 1:], axis=0) / 0.01
    allowed = np.array([1.5, 1.5, 3.0, *[6.0] * 7])
    assert (np.abs(steps) <= allowed + 1e-6).all()


def test_its_recording_tells_of_tree_robot_depth_grasp_and_signals(one_object):
    _, summary, folder = one_object
    chunks = RrdReader(folder / "recording.rrd").stream().to_chunks()
    entities = {str(chunk.entity_path) for chunk in chunks if not chunk.is_static}
    for part in ("/tree", "/world", "/camera", "/signals"):
        assert any(part in entity for entity in entities), (part, sorted(entities))
    rows = max(chunk.num_rows for chunk in chunks)
    assert rows <= summary["ticks"]


def test_the_same_seed_gives_the_same_commands_byte_for_byte(one_object, tmp_path):
    _, summary, folder = one_object
    _, again, other = run(tmp_path, "pick_one", "--scene", "single", "--seed", 1)
    assert again["ticks"] == summary["ticks"]
    assert (other / "commands.npy").read_bytes() == (folder / "commands.npy").read_bytes()


def test_an_empty_container_is_a_success(tmp_path):
    scene = tmp_path / "empty.yaml"
    shipped = Path(__file__).parents[2] / "hw" / "sim" / "scenes" / "single.yaml"
    scene.write_text(shipped.read_text().replace("count: 1", "count: 0"))
    code, summary, _ = run(tmp_path / "runs", "pick_place", "--scene", scene)
    assert code == 0
    assert summary["outcome"] == "success"
    assert "nothing left to grasp" in summary["reason"]
    assert (summary["placed"], summary["attempts"]) == (0, 0)


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["sim", "omni"])
def test_the_container_is_emptied(tmp_path, robot):
    code, summary, _ = run(tmp_path, "pick_place", "--seed", 0, "--robot", robot)
    assert code == 0
    assert summary["placed"] >= 8
    assert summary["limit_violations"] == 0
