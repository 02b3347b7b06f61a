"""A task that places where nothing stands is told of before it runs."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.commands import app
from app.core.surfaces import unsupported_places
from hw import WorldOptions, open_backend
from trees import shipped
from trees.language import load

TASK = """\
task: t
regions:
  here: {centre: [0.0, 1.6, %s], size: [1.0, 0.4, 0.2]}
  there: {centre: [0.0, %s, 0.60], size: [1.0, 0.4, 0.2]}
tree:
  sequence:
    - place: {on: here}
    - place: {on: there}
"""


def warnings(path: Path, scene: str = "household") -> list[str]:
    truth = open_backend("frankie", "kinematic", WorldOptions(scene=scene)).truth
    return unsupported_places(load(path), truth.fixtures)


@pytest.mark.parametrize("name", ["pick_one", "pick_place", "tidy_two_tables"])
def test_shipped_tasks_place_on_what_their_scene_has(name):
    task = load(shipped(name))
    assert warnings(shipped(name), task.scene or "household") == []


@pytest.mark.parametrize(
    ("height", "y", "expected"),
    [
        (0.60, 1.6, []),
        (0.75, 1.6, ["t.yaml:7:7: 10 of the 10 places on `here`", "the nearest is 0.15 m away"]),
        (0.45, 1.6, ["10 of the 10 places on `here`", "the nearest is 0."]),
        (0.60, -3.0, ["t.yaml:8:7: 10 of the 10 places on `there`", "is 0.50 m away"]),
    ],
)
def test_places_with_no_surface_under_them_are_told(tmp_path, height, y, expected):
    path = tmp_path / "t.yaml"
    path.write_text(TASK % (height, y))
    found = warnings(path)
    assert len(found) == bool(expected)
    assert all(text in found[0] for text in expected)


def test_a_region_that_hangs_over_the_edge_is_told_in_part(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(TASK % (0.60, 2.1))
    (text,) = warnings(path)
    assert "5 of the 10 places on `there`" in text or "10 of the 10" in text


def test_the_run_tells_it(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(TASK % (0.75, 1.6))
    command = ["run", str(path), "--view", "none", "--record", str(tmp_path / "runs"), "--json"]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 1
    assert "10 of the 10 places on `here` have no surface" in result.stderr
