"""A task of several files as several files of XML, which BehaviorTree.CPP reads."""

import shutil
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest
from command_line import call

bt = pytest.importorskip("behaviortreepy", reason="it has no wheels for this Python")


@pytest.fixture
def folder(tmp_path):
    files = Path(__file__).parent / "three_files"
    return Path(shutil.copytree(files, tmp_path, dirs_exist_ok=True))


def ticks(file: Path, tree: str, monkeypatch) -> Counter[str]:
    """How often BehaviorTree.CPP ticks each leaf of a file until it ends; no gripper opens."""
    done: Counter[str] = Counter()

    def answer(key: str) -> bt.NodeStatus:
        done[key] += 1
        return bt.NodeStatus.FAILURE if key == "open_gripper" else bt.NodeStatus.SUCCESS

    monkeypatch.chdir(file.parent)  # a text has its includes relative to this
    factory = bt.BehaviorTreeFactory()
    for key in ("open_gripper", "arm_healthy"):
        factory.register_simple_action(key, lambda node, key=key: answer(key))
    factory.register_behavior_tree_from_text(file.read_text(encoding="utf-8"))
    made = factory.create_tree(tree)
    for _ in range(50):
        if made.tick_exactly_once() != bt.NodeStatus.RUNNING:
            return done
    raise AssertionError("it does not end")


def test_bt_cpp_runs_files_that_include_each_other(folder, monkeypatch):
    out = folder / "xml"
    out.mkdir()
    code, said, _ = call("export", folder / "top.yaml", "--output", out / "robot.xml")
    assert code == 0
    written = ["robot.xml", "parts/one.xml", "parts/deep/two.xml"]
    assert said.splitlines() == [f"{out / name}: written" for name in written]
    # The default of a parameter, a given value, and a file that is used from two places.
    done = ticks(out / "robot.xml", "Main", monkeypatch)
    assert done == {"arm_healthy": 2 + 3, "open_gripper": 2 + 3 + 1}


def test_each_file_can_be_opened_alone(folder, monkeypatch):
    call("export", folder / "top.yaml", "--output", folder / "top.xml")
    assert ticks(folder / "parts" / "deep" / "two.xml", "two", monkeypatch)["open_gripper"] == 1
    for name, includes, models in (
        ("top.xml", ["parts/deep/two.xml", "parts/one.xml"], {"top"}),
        ("parts/one.xml", ["deep/two.xml"], {"one", "arm_healthy"}),
        ("parts/deep/two.xml", [], {"two", "open_gripper"}),
    ):
        root = ElementTree.parse(folder / name).getroot()
        assert [one.get("path") for one in root.findall("include")] == includes
        assert {one.get("ID") for one in root.find("TreeNodesModel")} == models
    tree = ElementTree.parse(folder / "top.xml").find("BehaviorTree[@ID='top']")
    assert tree.get("_scene") == "household"


def test_no_file_is_written_over_another(folder):
    (folder / "same.yaml").write_text("task: same\ntree: {subtree: {file: part.yaml}}\n")
    (folder / "part.yaml").write_text("task: part\ntree: {open_gripper: }\n")
    code, _, said = call("export", folder / "same.yaml", "--output", folder / "part.xml")
    assert (code, said.count("\n")) == (2, 1)
    assert "a subtree of the task belongs there" in said
    assert not (folder / "part.xml").exists()
