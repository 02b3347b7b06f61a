"""What a sound task file becomes: values, trees, the names of their nodes; the shipped tasks."""

import numpy as np
import pytest
from tree_toys import TOYS, ToyContext

import trees
from behaviours.core.parameter_types import Posture
from robots import load_robot
from trees.language import Task, build, load, nodes_in_order

READY = load_robot("frankie").arm.ready


@pytest.fixture
def task_of(tmp_path):
    def write(text: str) -> Task:
        path = tmp_path / "t.yaml"
        path.write_text("task: toy\n" + text)
        return load(path, leaves=TOYS)

    return write


def test_a_tool_pose_is_in_metres_and_degrees(task_of):
    task = task_of(
        "poses: {a: {xyz: [1, 2, 3], rpy_deg: [180, 0, 90]}}\ntree: {navigate: {to: a}}\n"
    )
    leaf = build(task, ToyContext())
    np.testing.assert_allclose(leaf.to.wTe.translation, [1, 2, 3])
    approach, closing = leaf.to.wTe.rotation[:, 2], leaf.to.wTe.rotation[:, 1]
    np.testing.assert_allclose(approach, [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(closing, [1, 0, 0], atol=1e-12)
    assert leaf.to.name == "a"
    assert leaf.timeout_s == 60.0


def test_a_base_pose_is_on_the_floor(task_of):
    task = task_of("poses: {a: {base: [1, 2], heading_deg: 90}}\ntree: {navigate: {to: a}}\n")
    wTb = build(task, ToyContext()).to.wTb
    np.testing.assert_allclose(wTb.translation, [1, 2, 0])
    np.testing.assert_allclose(wTb.rotation[:, 0], [0, 1, 0], atol=1e-12)


def test_a_region_is_a_turned_box(task_of):
    task = task_of(
        "regions: {a: {centre: [1, 0, 0.5], size: [0.4, 0.2, 0.2], yaw_deg: 90}}\n"
        "tree: {grasp: {within: a, lock_distance_m: 1, tries: null, side: right}}\n"
    )
    leaf = build(task, ToyContext())
    inside, outside = [1.0, 0.19, 0.5], [1.19, 0.0, 0.5]
    assert leaf.within.contains(np.array([inside, outside])).tolist() == [True, False]
    assert leaf.within.floor == pytest.approx(0.4)
    assert (leaf.lock_distance_m, leaf.tries, leaf.side) == (1.0, None, "right")
    assert type(leaf.lock_distance_m) is float


def test_postures_are_in_degrees_and_ready_is_always_known(task_of):
    folded = task_of(
        "poses: {a: {joints_deg: [0, -90, 0, 0, 0, 0, 180]}}\ntree: {recover: {arm: a}}\n"
    )
    np.testing.assert_allclose(
        build(folded, ToyContext()).arm.q, [0, -np.pi / 2, 0, 0, 0, 0, np.pi]
    )
    ready = build(task_of("tree: {recover: {arm: ready}}\n"), ToyContext()).arm
    assert isinstance(ready, Posture)
    np.testing.assert_array_equal(ready.q, READY)


def test_nodes_have_unique_paths_in_the_order_of_the_file(task_of):
    task = task_of("""\
description: twice
tree:
  sequence:
    - open_gripper
    - {name: pick, retry: 2, timeout_s: 1, sequence: [open_gripper, retreat_check, open_gripper]}
    - open_gripper
    - {name: open_gripper 2, open_gripper: }
""")
    placed = nodes_in_order(build(task, ToyContext()))
    assert [(place.path, place.depth) for place in placed] == [
        ("sequence", 0),
        ("sequence/open_gripper", 1),
        ("sequence/retry", 1),
        ("sequence/retry/timeout", 2),
        ("sequence/retry/timeout/pick", 3),
        ("sequence/retry/timeout/pick/open_gripper", 4),
        ("sequence/retry/timeout/pick/retreat_check", 4),
        ("sequence/retry/timeout/pick/open_gripper 2", 4),
        ("sequence/open_gripper 2", 1),
        ("sequence/open_gripper 2 2", 1),
    ]
    assert (task.name, task.description) == ("toy", "twice")


def test_a_tree_is_found_by_name_or_by_path(tmp_path, monkeypatch):
    assert trees.find("pick_place") == trees.shipped("pick_place")
    assert trees.find("mine/pick_place.yaml").as_posix() == "mine/pick_place.yaml"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plain").write_text("task: toy\n")
    assert trees.find("plain").as_posix() == "plain"
    (tmp_path / "mine.yaml").write_text("task: mine\n")
    assert trees.find("mine").as_posix() == "mine.yaml"
    with pytest.raises(
        trees.UnknownTreeError,
        match=r"^no tree is called `pick_plce`; did you mean `pick_place`\? Give a file or one of",
    ):
        trees.find("pick_plce")
    with pytest.raises(trees.UnknownTreeError, match="did you mean `mine`"):
        trees.find("mien")
