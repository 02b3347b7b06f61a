"""A task that sends the robot where it cannot be, or puts things where nothing is, is refused."""

import pytest
from command_line import call
from mistakes import MARK, TABLES, marked, table

from config import Severity
from trees import shipped, shipped_names
from trees.language import load
from trees.site import check


def mistakes(folder, place: str, use: str, robot: str = "frankie"):
    text = TABLES["in_places"].replace("PLACE", place).replace("USE", use)
    path = folder / "t.yaml"
    path.write_text(text.replace(MARK, ""))
    return marked(text), [one for one in check(path, robot=robot) if one.location]


@table("poses")
def test_a_pose_where_the_robot_cannot_be_is_refused_where_it_is_defined(tmp_path, row):
    at, found = mistakes(tmp_path, row["place"], row["use"])
    [one] = [one for one in found if one.severity is Severity.ERROR]
    assert (one.location.line, one.location.column) == at
    assert row["tells"] in str(one)
    assert one.hint


def told_where_marked(folder, row, severity):
    at, [one] = mistakes(folder, row["place"], row["use"])
    assert (one.location.line, one.location.column) == at
    assert one.severity is severity
    assert row["tells"] in str(one)


@table("uses")
def test_a_place_that_its_use_does_not_fit_is_refused(tmp_path, row):
    told_where_marked(tmp_path, row, Severity.ERROR)


@table("hardly")
def test_a_place_that_hardly_fits_is_warned_of(tmp_path, row):
    told_where_marked(tmp_path, row, Severity.WARNING)


def test_a_pose_that_is_only_looked_at_may_be_anywhere(tmp_path):
    place = f"  {MARK}x: {{xyz: [0, 1.6, 0.45], rpy_deg: [180, 0, 0]}}"
    assert mistakes(tmp_path, place, "look_at: {at: x}")[1] == []


@pytest.mark.parametrize("robot", ["frankie", "omni"])
@pytest.mark.parametrize("name", shipped_names())
def test_the_shipped_tasks_can_be_done_and_are_named_as_their_files(name, robot):
    assert check(shipped(name), robot=robot) == []
    task = load(shipped(name))
    assert (task.name, bool(task.description)) == (name, True)


SCENES = (
    ("¦kitchn", "did you mean `kitchen`?"),
    ("¦broken.yaml", "the scene `broken.yaml` has mistakes"),
)


@pytest.mark.parametrize(("scene", "why"), SCENES)
def test_a_scene_that_cannot_be_used_is_told_where_it_is_named(tmp_path, scene, why):
    (tmp_path / "broken.yaml").write_text("container: {centre: [3, 0]}\ntable: {centr: [0, 1.6]}\n")
    text = f"task: t\nscene: {scene}\ntree: open_gripper\n"
    path = tmp_path / "t.yaml"
    path.write_text(text.replace(MARK, ""))
    found = check(path)
    assert (found[0].location.line, found[0].location.column) == marked(text)
    assert why in str(found[0])
    # Then come the mistakes of the scene file at their own lines.
    assert len(found) == (3 if "broken" in scene else 1)


def test_a_scene_is_found_beside_the_task_that_names_it(tmp_path, monkeypatch):
    (tmp_path / "task").mkdir()
    (tmp_path / "task" / "empty.yaml").write_text(
        "container: {centre: [3, 0]}\ntable: {centre: [0, 1.6]}\nobjects: {count: 0}\n"
    )
    path = tmp_path / "task" / "t.yaml"
    path.write_text("task: t\nscene: empty.yaml\ntree: open_gripper\n")
    monkeypatch.chdir(tmp_path)
    assert check(path) == []
    code, out, _ = call("run", "task/t.yaml", "--record", tmp_path / "runs")
    assert code == 0, out


def test_every_mistake_of_a_scene_file_is_told_at_once(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(
        """\
container: {centre: [0, 0]}
table: {centre: [0, 1600], size: [1.2, 0.6], hight: 0.5}
objects: {count: -1, kinds: [bxo], width_mm: [70, 15]}
walkers: [{name: Ada, way: [[1, 1], [1, 1]]}]
"""
    )
    code, out, _ = call("check", path)
    assert code == 2
    places = [line.removeprefix(f"{path}:").split(" ")[0] for line in out.splitlines()]
    assert places == ["1:1:", "2:21:", "2:46:", "3:18:", "3:29:", "3:46:", "4:28:"]


@pytest.mark.parametrize(("named", "code"), [("scene: single\n", 2), ("", 0)])
def test_a_run_refuses_what_check_refuses_and_warns_in_other_scenes(tmp_path, named, code):
    path = tmp_path / "t.yaml"
    path.write_text(
        f"task: t\n{named}regions:\n  x: {{centre: [0, -2, 0.6], size: [0.4, 0.4, 0.2]}}\n"
        "tree: {force: success, place: {on: x}}\n"
    )
    ended, _, err = call("run", path, "--record", tmp_path / "runs")
    assert (ended, call("check", path)[0]) == (code, code)
    assert "places on `x` have no surface of the scene under them" in err


SHELF = """\
task: corpus
scene: shelf
regions:
  trolley: {centre: [0.0, 1.6, 0.85], size: [0.5, 0.4, 0.2]}
  middle: {centre: [2.52, 0.0, 0.85], size: [0.2, 0.44, 0.2]}
tree: {sequence: [grasp: {within: trolleyTILT}, place: {on: middle}]}
"""


@pytest.mark.parametrize(("tilt", "warned"), [("", True), (", least_tilt_deg: 45", False)])
def test_a_place_in_a_shelf_for_what_is_gripped_straight_down_is_warned_of(tmp_path, tilt, warned):
    path = tmp_path / "t.yaml"
    path.write_text(SHELF.replace("TILT", tilt))
    found = [one for one in check(path) if one.location]
    assert [(one.location.line, one.severity) for one in found] == [(6, Severity.WARNING)] * warned
    assert all("least_tilt_deg: 45" in one.hint for one in found)
