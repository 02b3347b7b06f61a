"""What an author means: tasks that are sound, and mistakes that only the whole of a task shows."""

from pathlib import Path

import pytest
import yaml
from mistakes import MARK, marked

from robots import SHIPPED
from trees.site import check

CASES = yaml.safe_load((Path(__file__).parent / "meant.yaml").read_text("utf-8"))
MACROS = CASES["macros"]


def found_in(folder: Path, text: str) -> list[str]:
    """The diagnostics but those of names that are not used, without the path."""
    path = folder / "t.yaml"
    path.write_text(text.replace(MARK, ""), encoding="utf-8")
    found = [one for one in check(path) if one.rule.code != "R401"]
    return [str(one).removeprefix(f"{path}:") for one in found]


def task(tree: str) -> str:
    text = f"{CASES['world']}  {tree}\n"
    for name, meaning in MACROS.items():
        text = text.replace(name, meaning)
    return text


@pytest.mark.parametrize("tree", CASES["good"])
def test_what_is_meant_so_is_good(tmp_path, tree):
    assert found_in(tmp_path, task(tree)) == []


@pytest.mark.parametrize("case", CASES["odd"], ids=[case["tree"] for case in CASES["odd"]])
def test_a_mistake_is_told_where_it_is_with_its_cause_and_remedy(tmp_path, case):
    text = task(case["tree"])
    told = [one for one in found_in(tmp_path, text) if case["tells"] in one]
    assert told, found_in(tmp_path, text)
    if MARK in text:
        line, column = marked(text)
        assert told[0].startswith(f"{line}:{column}: ")


@pytest.mark.parametrize("case", CASES["files"], ids=[case["tells"] for case in CASES["files"]])
def test_a_file_that_is_written_wrongly_is_told_how_to_repair_it(tmp_path, case):
    line, column = marked(case["text"])
    told = [one for one in found_in(tmp_path, case["text"]) if case["tells"] in one]
    assert told, found_in(tmp_path, case["text"])
    assert told[0].removeprefix("warning: ").startswith(f"{line}:{column}: ")


def test_hands_are_followed_through_other_files(tmp_path):
    (tmp_path / "pick.yaml").write_text(
        "task: pick\nparams: {above: {type: tool_pose}, box: {type: region}}\n"
        "tree: {sequence: [navigate: {to: $above}, open_gripper, grasp: {within: $box}]}\n"
    )
    pick = "subtree: {file: pick.yaml, with: {above: above, box: box}}"
    assert found_in(tmp_path, task(f"sequence: [{pick}, CARRY, PUT]")) == []
    [found] = found_in(tmp_path, task(f"sequence: [{pick}, open_gripper, CARRY, PUT]"))
    assert "`place` has nothing in the hand here" in found


def test_places_are_checked_on_the_map_of_a_real_robot(tmp_path):
    site = (SHIPPED / "frankie_site.yaml").read_text("utf-8")
    robot, text = tmp_path / "ours.yaml", task("navigate: {to: inside}")
    robot.write_text(site.replace("# map: my_hall.yaml", "map: single"), encoding="utf-8")
    text = text.replace("scene: single\n", "").replace(
        "poses:\n", "poses:\n  inside: {xyz: [0.0, 1.60, 0.48], rpy_deg: [180, 0, 90]}\n"
    )
    path = tmp_path / "t.yaml"
    path.write_text(text, encoding="utf-8")
    assert "inside table/top" in " ".join(map(str, check(path, robot=robot)))
    assert "inside table/top" not in " ".join(map(str, check(path)))
