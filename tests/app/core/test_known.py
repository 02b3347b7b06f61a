"""What the robot is told of its surroundings: the world's own map, or that of a file."""

import pytest

from app.core import RunOptions, run_task
from app.core.known import known_of, known_then
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


def names(known):
    return {fixture.name.partition("/")[0] for fixture in known.fixtures}


def test_a_simulated_world_tells_its_map_and_its_walkers_but_not_the_floor():
    known = known_of(truth_of("crossing"))
    assert {"table", "container", "pedestal"} <= names(known)
    assert "floor" not in names(known)
    assert [one.geom.name for one in known.obstacles(0.0)] == ["person"]


def test_a_robot_on_hardware_knows_nothing_without_a_map(tmp_path):
    nothing = known_of(None)
    assert not nothing.fixtures
    assert not nothing.obstacles(0.0)
    (tmp_path / "site.yaml").write_text(SITE)
    assert "fence" in names(known_of(None, tmp_path / "site.yaml"))


def test_what_was_known_then_is_known_again():
    truth, then = truth_of("crossing"), known_then("crossing", 0, None)
    truth.move_to(1.23)
    (now,), (again,) = truth.moving(), then.obstacles(1.23)
    assert (now.geom.pose.translation == again.geom.pose.translation).all()
    assert (now.velocity == again.velocity).all()


def test_the_base_drives_around_what_only_the_map_knows(tmp_path):
    (tmp_path / "site.yaml").write_text(SITE)
    (tmp_path / "ahead.yaml").write_text(TASK)
    options = RunOptions(tree=tmp_path / "ahead.yaml", record=tmp_path / "runs")
    straight = run_task(options).summary.duration_s
    around = RunOptions(
        tree=tmp_path / "ahead.yaml", record=tmp_path / "runs", map=tmp_path / "site.yaml"
    )
    result = run_task(around)
    assert result.outcome.end.name == "SUCCESS"
    assert result.summary.duration_s > straight + 1.0


def test_a_map_that_is_not_there_is_refused_in_a_line(tmp_path):
    with pytest.raises(SceneError, match="no scene is called"):
        known_of(None, tmp_path / "nothing.yaml")
