"""What a task file becomes: values, trees, names of nodes, or all of its errors at once."""

import numpy as np
import pytest
from tree_toys import TOYS, ToyContext, check

import trees
from behaviours.core.parameter_types import Posture
from robots import load_robot
from trees.language import Task, TaskFileError, build, load, nodes_in_order


@pytest.fixture
def task_of(tmp_path):
    def write(text: str) -> Task:
        path = tmp_path / "t.yaml"
        path.write_text("task: toy\n" + text)
        return load(path, leaves=TOYS)

    return write


PLACES = """\
poses:
  tool: {xyz: [1, 2, 3], rpy_deg: [180, 0, 90]}
  base: {base: [1, 2], heading_deg: 90}
  folded: {joints_deg: [0, -90, 0, 0, 0, 0, 180]}
regions: {box: {centre: [1, 0, 0.5], size: [0.4, 0.2, 0.2], yaw_deg: 90}}
tree:
  sequence:
    - navigate: {to: tool}
    - navigate: {to: base}
    - recover: {arm: folded}
    - recover: {arm: ready}
    - grasp: {within: box, lock_distance_m: 1, tries: null, side: right}
"""


def test_places_are_in_metres_and_degrees_and_arguments_of_their_types(task_of):
    tool, base, folded, ready, grasp = build(task_of(PLACES), ToyContext()).children
    assert (tool.to.name, tool.timeout_s) == ("tool", 60.0)
    np.testing.assert_allclose(tool.to.oTe.translation, [1, 2, 3])
    closing, approach = tool.to.oTe.rotation[:, 1:].T
    np.testing.assert_allclose([approach, closing], [[0, 0, -1], [1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(base.to.oTb.translation, [1, 2, 0])
    np.testing.assert_allclose(base.to.oTb.rotation[:, 0], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(folded.arm.q, [0, -np.pi / 2, 0, 0, 0, 0, np.pi])
    assert isinstance(ready.arm, Posture)
    np.testing.assert_array_equal(ready.arm.q, load_robot("frankie").arm.ready)
    inside, outside = [1.0, 0.19, 0.5], [1.19, 0.0, 0.5]
    assert grasp.within.contains(np.array([inside, outside])).tolist() == [True, False]
    assert grasp.within.floor == pytest.approx(0.4)
    assert (grasp.lock_distance_m, grasp.tries, grasp.side) == (1.0, None, "right")
    assert type(grasp.lock_distance_m) is float


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


UNUSED = """\
task: toy
params: {count: {default: 3}, speed: {default: 1.5}}
poses:
  home: {xyz: [1, 2, 3], rpy_deg: [180, 0, 0]}
  dock: {base: [0, 0], heading_deg: 90}
  folded: {joints_deg: [0, -17, 0, -126, 0, 115, 45]}
regions: {box: {centre: [0, 0, 0.5], size: [1, 1, 0.2]}}
tree: {retry: $count, navigate: {to: home}}
"""


def test_all_mistakes_of_a_file_are_reported_at_once_in_its_order(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(
        "task: toy\nposes: {home: {xyz: [1, 2], rpy_deg: [0, 0, 0]}}\n"
        "tree:\n  sequence:\n    - navigate: {to: home, timeout_s: soon}\n    - opn_gripper\n"
    )
    found = [str(one) for one in check(path, leaves=TOYS)]
    places = [line.removeprefix(f"{path}:").split(": ")[0] for line in found]
    assert places == ["2:21", "5:39", "6:7"]
    with pytest.raises(TaskFileError) as raised:
        load(path, leaves=TOYS)
    assert str(raised.value).splitlines() == found


def test_a_message_is_one_line_whatever_it_quotes(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text('task: "a\\n\\e[31m b' + "c" * 1000 + '"\ntree: open_gripper\n')
    [found] = map(str, check(path, leaves=TOYS))
    assert found.startswith(f"{path}:1:7: task: `a [31m bccc")
    assert found.isprintable()
    assert len(found.removeprefix(str(path))) < 600


def test_files_that_cannot_be_read(tmp_path):
    def only(path):
        [diagnostic] = check(path, leaves=TOYS)
        return str(diagnostic).removeprefix(str(path))

    latin, large = tmp_path / "latin.yaml", tmp_path / "large.yaml"
    latin.write_bytes(b"task: toy\ndescription: H\xc3\xb6he f\xfcr\n")
    large.write_text("#" * 256_001)
    cannot = "the file cannot be read"
    assert only(tmp_path / "missing.yaml") == ": there is no such file; check the path"
    assert only(tmp_path) == f": {cannot} (Is a directory); name a readable file"
    assert only(latin) == f":2:20: {cannot}: byte 0xfc is not UTF-8 text; save it as UTF-8"
    assert only(large) == ": the file is larger than 256 kB; split it into smaller files"


def test_what_nothing_uses_is_a_warning_and_the_task_still_loads(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(UNUSED)
    found = [str(diagnostic).removeprefix(f"{path}:") for diagnostic in check(path, leaves=TOYS)]
    assert [one.partition(";")[0] for one in found] == [
        "2:31: warning: the parameter `speed` is never used",
        "5:3: warning: `dock` is never used",
        "6:3: warning: `folded` is never used",
        "7:11: warning: `box` is never used",
    ]
    assert len(load(path, leaves=TOYS).warnings) == 4
