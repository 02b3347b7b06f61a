"""The world model that the robot is given: the world's own map, or that of a file."""

import numpy as np
import pytest

from app.core import RunOptions, run_task
from app.core.world_model import delivered, load_world_model, recorded_world_model
from hw import WorldOptions, open_backend
from hw.sim import SceneError

SITE = """\
container: {centre: [3.0, 0.0]}
table: {centre: [0.0, 1.6]}
fixtures:
  - {name: fence, centre: [1.5, 0, 0.5], size: [0.1, 2.0, 1.0]}
"""
TASK = """\
task: ahead
poses: {there: {base: [1.9, 0], heading_deg: 0}}
tree: {drive: {to: there}}
"""


def truth_of(scene):
    return open_backend("frankie", "kinematic", WorldOptions(scene=scene)).truth


def names(model):
    return {fixture.name.partition("/")[0] for fixture in model.fixtures}


def test_a_simulated_world_gives_its_map_and_its_walkers_without_the_floor():
    model = load_world_model(truth_of("crossing"))
    assert {"table", "container", "pedestal"} <= names(model)
    assert "floor" not in names(model)
    assert [one.geom.name for one in model.obstacles(0.0)] == ["person"]


def test_hardware_has_only_the_map_of_a_file(tmp_path):
    nothing = load_world_model(None)
    assert not nothing.fixtures
    assert not nothing.obstacles(0.0)
    (tmp_path / "site.yaml").write_text(SITE)
    assert "fence" in names(load_world_model(None, tmp_path / "site.yaml"))
    with pytest.raises(SceneError, match="no scene is called"):
        load_world_model(None, tmp_path / "nothing.yaml")


def test_the_world_model_of_a_recorded_run_is_the_same():
    truth, model = truth_of("crossing"), recorded_world_model("crossing", 0, None)
    truth.move_to(1.23)
    (now,), (again,) = truth.moving(), model.obstacles(1.23)
    assert (now.geom.pose.translation == again.geom.pose.translation).all()
    assert (now.velocity == again.velocity).all()


@pytest.mark.slow
def test_the_base_drives_around_what_only_the_map_has(tmp_path):
    (tmp_path / "site.yaml").write_text(SITE)
    (tmp_path / "ahead.yaml").write_text(TASK)
    run = RunOptions(
        tree=tmp_path / "ahead.yaml",
        record=tmp_path / "runs",
        recording=False,
        map=tmp_path / "site.yaml",
        localisation="exact",  # else it is lost: it does not see the fence
    )
    result = run_task(run)
    assert result.outcome.end.name == "SUCCESS"
    y = np.load(result.folder / "states.npy")[:, 2]
    assert np.abs(y).max() > 0.8


def test_only_what_stands_on_other_furniture_is_delivered():
    before = {name: "table" for name in "abcd"}
    after = {"a": "shelf", "b": "table", "c": "floor", "d": "hand"}
    assert delivered(before, after) == 1
