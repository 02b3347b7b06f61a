"""The files of subtrees: circles, links, and how many there may be."""

import pytest
from subtree_files import errors, write_files
from tree_toys import TOYS, ToyContext

from trees.language import build, load


@pytest.fixture
def folder(tmp_path):
    return write_files(tmp_path)


def test_a_link_out_of_the_folder_is_refused(folder, tmp_path_factory):
    outside = tmp_path_factory.mktemp("outside") / "secret.yaml"
    outside.write_text("task: part\ntree: open_gripper\n")
    (folder / "parts" / "link.yaml").symlink_to(outside)
    [found] = errors(folder, "task: top\ntree: {subtree: {file: parts/link.yaml}}\n")
    assert "`parts/link.yaml` leads out of the folder of the task" in found


def test_a_link_that_leads_nowhere_is_no_file(folder):
    (folder / "loop.yaml").symlink_to(folder / "loop.yaml")
    [found] = errors(folder, "task: top\ntree: {subtree: {file: loop.yaml}}\n")
    assert found.startswith("top.yaml:2:24: ")


def test_subtrees_that_multiply_are_bounded(folder):
    for number in range(10):
        deeper = f"subtree: {{file: p{number + 1}.yaml}}" if number < 9 else "open_gripper: "
        twice = f"task: p\ntree: {{sequence: [{{{deeper}}}, {{{deeper}}}]}}\n"
        (folder / f"p{number}.yaml").write_text(twice)
    [found] = errors(folder, "task: top\ntree: {subtree: {file: p0.yaml}}\n")
    assert "the task has more than 200 subtrees" in found


def test_the_depth_of_the_whole_tree_is_bounded(folder):
    words = ["force_success: true", "once: true", "cooldown_s: 1", "retry: 2", "repeat: 2"]
    modified = "{" + ", ".join([*words, "delay_s: 1", "timeout_s: 9"]) + ", %s}"
    nest = "%s"
    for _ in range(6):
        nest %= modified % "forever: %s"
    (folder / "last.yaml").write_text(f"task: last\ntree: {nest % '{open_gripper: }'}\n")
    (folder / "top.yaml").write_text(f"task: top\ntree: {nest % '{subtree: {file: last.yaml}}'}\n")
    root = build(load(folder / "top.yaml", leaves=TOYS), ToyContext())
    root.tick_once()
    deeper = modified % f"forever: {nest % '{subtree: {file: last.yaml}}'}"
    [found] = errors(folder, f"task: top\ntree: {deeper}\n")
    assert found.startswith("last.yaml:2:")
    assert "the tree is more than 100 levels deep here, modifiers counted" in found
