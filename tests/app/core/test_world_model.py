"""The world model that the robot is given: the world's own map, or that of a file."""

import numpy as np
import pytest

from app.core import RunOptions, run_task
from app.core.setup import delivered, load_world_model, recorded_world_model
from hw import WorldOptions, open_backend
from hw.sim import SceneError

SITE = """\
container: {centre: [3.0, 0.0]}
table: {centre: [0.0, 1.6]}
fixtures:
  - {name: fence, centre: [1.5, 0, 0.5], size: [0.1, 2.0, 1.0]}
"""
TASK = "task: ahead\nposes: {there: {base: [1.9, 0], heading_deg: 0}}\ntree: {drive: {to: there}}\n"


def names(model):
    return {fixture.name.partition("/")[0] for fixture in model.fixtures}


def test_a_simulated_world_gives_its_map_and_its_walkers_also_when_it_is_recorded():
    truth = open_backend("frankie", "kinematic", WorldOptions(scene="crossing")).truth
    model = load_world_model(truth)
    assert {"table", "container", "pedestal"} <= names(model)
    assert "floor" not in names(model)
    truth.move_to(1.23)
    (now,), (again,) = truth.moving(), recorded_world_model("crossing", 0, None).obstacles(1.23)
    assert (model.obstacles(0.0)[0].geom.name, now.geom.name) == ("person", "person")
    assert (now.geom.pose.translation == again.geom.pose.translation).all()
    assert (now.velocity == again.velocity).all()


def test_hardware_has_only_the_map_of_a_file(tmp_path):
    nothing = load_world_model(None)
    assert (nothing.fixtures, nothing.obstacles(0.0)) == ((), ())
    (tmp_path / "site.yaml").write_text(SITE)
    assert "fence" in names(load_world_model(None, tmp_path / "site.yaml"))
    with pytest.raises(SceneError, match="no scene is called"):
        load_world_model(None, tmp_path / "nothing.yaml")


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
