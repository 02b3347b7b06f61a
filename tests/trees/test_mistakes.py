"""What cannot be meant is refused where it stands, and what hardly is, is warned of.

Mistakes of form and names are in the folder `broken`.
"""

import re
from pathlib import Path

import pytest
from command_line import call
from mistakes import file_with, found_in, found_in_toys, marked, table
from tree_toys import check

from config import Severity


@table("errors")
def test_what_cannot_be_meant_is_refused_where_it_stands(tmp_path, row):
    text = file_with(row["task"])
    [found] = found_in(tmp_path, text)
    assert (found.location.line, found.location.column) == marked(text)
    assert row["tells"] in str(found)
    assert found.hint


@table("warnings")
def test_what_is_probably_not_meant_is_warned_of(tmp_path, row):
    text = file_with(row["task"])
    assert found_in(tmp_path, text) == []
    [found] = found_in(tmp_path, text, Severity.WARNING)
    assert (found.location.line, found.location.column) == marked(text)
    assert row["tells"] in str(found)


@table("fine")
def test_what_can_be_meant_is_good(tmp_path, row):
    text = file_with(row)
    assert found_in(tmp_path, text) == []
    assert found_in(tmp_path, text, Severity.WARNING) == []


def test_values_within_values_are_bounded(tmp_path):
    numbers = ", ".join(str(number) for number in range(100))
    inner = f"for_each: {{item: b, in: [{numbers}], do: {{wait: {{duration_s: $b}}}}}}"
    text = file_with(f"- ¦for_each: {{item: a, in: [{numbers}], do: {{{inner}}}}}")
    found = found_in(tmp_path, text)
    assert "more than 1000 nodes" in str(found[0])


FOLDER = Path(__file__).parent / "broken"
FILES = sorted(FOLDER.glob("*.yaml"))
EXPECTED = re.compile(r"# expect (?:(?P<file>\S+\.yaml):)?(?P<place>\d+:\d+): (?P<message>.+)")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_mistake_is_found_where_it_is(path):
    expected = [match for match in map(EXPECTED.fullmatch, path.read_text().splitlines()) if match]
    found = [
        diagnostic
        for diagnostic in map(str, check(path))
        if "warning" not in diagnostic.split(" ")[1]
    ]
    assert len(found) == len(expected), found
    for text, match in zip(found, expected, strict=True):
        assert text.startswith(f"{FOLDER / (match['file'] or path.name)}:{match['place']}: ")
        assert match["message"] in text


def warnings(folder, tree: str) -> list[str]:
    assert found_in_toys(folder, tree, Severity.ERROR) == []
    return found_in_toys(folder, tree, Severity.WARNING)


@table("odd")
def test_what_is_odd_is_a_warning(tmp_path, row):
    found = [text for text in warnings(tmp_path, row["task"]) if "cannot succeed:" not in text]
    assert [text.split(": ", 1)[1] for text in found] == [row["tells"]]


@table("sound")
def test_what_is_meant_is_no_warning(tmp_path, row):
    assert warnings(tmp_path, row) == []


def test_warnings_are_where_the_node_is(tmp_path):
    tree = "sequence:\n  - ask: {answers: S}\n  - open_gripper"
    assert warnings(tmp_path, tree)[0].startswith("2:5: ")


def test_what_only_a_subtree_can_tell(tmp_path):
    (tmp_path / "sure.yaml").write_text("task: sure\ntree: {force: success, play: {script: S}}\n")
    [found] = warnings(tmp_path, "fallback: [subtree: {file: sure.yaml}, open_gripper]")
    assert "`open_gripper` is never reached: `sure` before it never fails" in found


def test_a_file_with_warnings_alone_passes(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text("task: t\nparams: {a: {default: 1}}\ntree: open_gripper\n")
    code, out, _ = call("check", path)
    assert code == 0
    assert f"{path}:2:10: warning: the parameter `a` is never used; " in out
    assert f"{path}: good" in out
