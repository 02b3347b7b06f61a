"""A file with the poses and regions of a site, and poses that are taught into it."""

import re

import numpy as np
import pytest
from command_line import call
from harness import Harness, looking_down
from tree_toys import check

from app.authoring.teach import Form, path
from robots import load_robot
from trees.language import TaskFileError, load
from trees.site import check as check_places

TASK = """\
task: t
poses:
  dock: {base: [0, 0], heading_deg: 0}
tree: {drive: {to: dock}}
"""
SITE = """\
description: Our laboratory.
poses:
  dock: {base: [0.5, 0.25], heading_deg: 90} # beside the door
regions:
  shelf: {centre: [0, 1, 0.5], size: [1, 0.3, 0.2]}
"""


@pytest.fixture
def task(tmp_path):
    (path := tmp_path / "t.yaml").write_text(TASK)
    return path


@pytest.fixture
def site(tmp_path):
    (path := tmp_path / "places.yaml").write_text(SITE)
    return path


def test_the_site_says_where_a_pose_is_and_a_task_may_leave_its_places_to_it(task, site):
    own, there = load(task), load(task, places=site)
    assert own.root.arguments["to"].oTb.translation[0] == 0.0
    assert there.root.arguments["to"].oTb.translation[:2].tolist() == [0.5, 0.25]
    task.write_text("task: t\ntree: {look_at: {at: shelf}}\n")
    assert check(task, places=site) == []
    with pytest.raises(TaskFileError, match="is called `shelf`"):
        load(task)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("poses:\n  dock: {base: [500, 0], heading_deg: 0}\n", "2:17: .*did you mean 0.5"),
        ("pose: {}\n", "1:1: .*did you mean `poses`?"),
        ("poses:\n  dock: {xyz: [1, 0, 2.5], rpy_deg: [180, 0, 0]}\n", "2:3: `dock`: out of reach"),
    ],
)
def test_a_mistake_in_the_file_of_places_is_told_where_it_is(task, site, text, told):
    task.write_text("task: t\ntree: {navigate: {to: dock}}\n")
    site.write_text(text)
    code, out, _ = call("check", task, "--places", site)
    assert code == 2
    assert re.search(f"^{site}:{told}", out, re.M)


def test_a_run_goes_where_the_site_says(task, site, tmp_path):
    to = ("--record", tmp_path / "runs", "--replayable")
    code, out, _ = call("run", task, "--places", site, *to)
    assert code == 0, out
    [folder] = (tmp_path / "runs").iterdir()
    assert (folder / "places.yaml").read_text() == SITE
    assert call("replay", folder)[0] == 0


def test_what_is_taught_is_where_the_robot_is(task, site):
    assert call("teach", "here", "--places", site)[0] == 0
    assert call("teach", "parked", "--of", "base", "--places", site)[0] == 0
    assert call("teach", "folded", "--of", "arm", "--places", site)[0] == 0
    tree = "  sequence: [navigate: {to: here}, drive: {to: parked}, move_arm: {to: folded}]\n"
    task.write_text(f"task: t\ntree:\n{tree}")
    here, parked, folded = (node.arguments["to"] for node in load(task, places=site).root.children)
    robot = load_robot("frankie")
    np.testing.assert_allclose(folded.q, robot.arm.ready, atol=np.deg2rad(0.06))
    np.testing.assert_allclose(parked.oTb.homogeneous, np.eye(4), atol=1e-9)
    assert 0.3 < here.oTe.translation[0] < 1.0
    assert check_places(task, places=site) == []
    # What a person wrote stays.
    assert "# beside the door" in site.read_text()
    assert "Our laboratory" in site.read_text()


def test_a_path_is_taught_pose_by_pose(task, site):
    harness, heights = Harness(), iter([0.6, 0.7])

    def more() -> bool:
        if height := next(heights, None):
            harness.reach_over(looking_down(0.6, 0.1, height))
        return bool(height)

    site.write_text(f"poses:\n  way:{path(harness.robot, Form.HAND, more)}\n")
    task.write_text("task: t\ntree: {for_each: {item: p, in: way, do: {navigate: {to: $p}}}}\n")
    poses = [node.arguments["to"].oTe for node in load(task, places=site).root.children]
    at = [pose.translation for pose in poses]
    np.testing.assert_allclose(at, [[0.6, 0.1, 0.6], [0.6, 0.1, 0.7]], atol=0.02)


def test_a_path_is_replaced_and_checked_as_a_whole(task, site):
    site.write_text("poses:\n  way: # round\n  - {base: [0, 0], heading_deg: 0}\n\nregions: {}\n")
    assert call("teach", "way", "--path", "--replace", "--places", site, typed="\n\nq\n")[0] == 0
    first, way, one, other, *rest = site.read_text().splitlines()
    assert (first, way, one, rest) == ("poses:", "  way: # round", other, ["", "regions: {}"])
    task.write_text("task: t\ntree: {navigate: {to: way}}\n")
    assert "`way` is a path" in call("check", task, "--places", site)[1]
    task.write_text("task: t\ntree: {for_each: {item: p, in: way, do: {navigate: {to: $p}}}}\n")
    assert check_places(task, places=site) == []
    site.write_text(site.read_text().replace("xyz: [0.634, 0, 0.793]", "xyz: [0.6, 0, 2.7]", 1))
    [far] = check_places(task, places=site)
    assert str(far).startswith(f"{site}:3:7: `way_1`: out of reach")


def test_a_pose_that_is_there_is_replaced_only_on_request(task, site):
    code, _, err = call("teach", "dock", "--of", "base", "--places", site)
    assert (code, "add --replace" in err) == (2, True)
    assert site.read_text() == SITE
    assert call("teach", "dock", "--of", "base", "--places", site, "--replace")[0] == 0
    assert "  dock: {base: [0, 0], heading_deg: 0} # beside the door\n" in site.read_text()


def test_a_file_of_places_is_begun_by_the_first_pose(tmp_path):
    site = tmp_path / "new.yaml"
    assert call("teach", "start", "--of", "base", "--places", site)[0] == 0
    assert site.read_text() == "poses:\n  start: {base: [0, 0], heading_deg: 0}\n"
    code, _, err = call("teach", "no name", "--places", site)
    assert (code, "cannot be the name" in err) == (2, True)
