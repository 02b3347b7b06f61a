"""Task files as a whole: all errors at once, overrides, files that cannot be read."""

import pytest
from tree_toys import TOYS

from trees.language import TaskFileError, check, load

HEAD = """\
task: toy
params:
  count: {default: 3, description: how many}
  speed: {default: 1.5}
poses:
  home: {xyz: [1, 2, 3], rpy_deg: [180, 0, 0]}
  dock: {base: [0, 0], heading_deg: 90}
  folded: {joints_deg: [0, -17, 0, -126, 0, 115, 45]}
regions:
  box: {centre: [0, 0, 0.5], size: [1, 1, 0.2]}
tree:
"""


def test_all_mistakes_of_a_file_are_reported_at_once_in_its_order(tmp_path):
    text = (
        "task: toy\n"
        "poses:\n"
        "  home: {xyz: [1, 2], rpy_deg: [0, 0, 0]}\n"
        "tree:\n"
        "  sequence:\n"
        "    - navigate: {to: home, timeout_s: soon}\n"
        "    - opn_gripper\n"
    )
    path = tmp_path / "t.yaml"
    path.write_text(text)
    found = [str(one) for one in check(path, leaves=TOYS)]
    places = [line.removeprefix(f"{path}:").split(": ")[0] for line in found]
    assert places == ["3:15", "6:39", "7:7"]
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
        return str(diagnostic)

    missing = tmp_path / "missing.yaml"
    assert only(missing) == f"{missing}: there is no such file; check the path"
    assert only(tmp_path) == (
        f"{tmp_path}: the file cannot be read (Is a directory); name a readable file"
    )
    latin = tmp_path / "latin.yaml"
    latin.write_bytes(b"task: toy\ndescription: H\xc3\xb6he f\xfcr\n")
    assert (
        only(latin)
        == f"{latin}:2:20: the file cannot be read: byte 0xfc is not UTF-8 text; save it as UTF-8"
    )
    large = tmp_path / "large.yaml"
    large.write_text("#" * 256_001)
    assert only(large) == f"{large}: the file is larger than 256 kB; split it into smaller files"


def test_what_nothing_uses_is_a_warning_and_the_task_still_loads(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(HEAD + "  {retry: $count, navigate: {to: home}}\n")
    found = [str(diagnostic).removeprefix(f"{path}:") for diagnostic in check(path, leaves=TOYS)]
    assert found == [
        "4:3: warning: the parameter `speed` is never used; write `$speed` somewhere, or remove it",
        "7:3: warning: `dock` is never used; name it in the tree, or remove it",
        "8:3: warning: `folded` is never used; name it in the tree, or remove it",
        "10:3: warning: `box` is never used; name it in the tree, or remove it",
    ]
    assert len(load(path, leaves=TOYS).warnings) == 4
