"""What the XML of BehaviorTree.CPP cannot say is refused where it stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from trees.btcpp import export_xml
from trees.language import TaskFileError, load


def exported(path: Path) -> str:
    return export_xml(load(path, open_parameters=True))


def write(folder: Path, tree: str, sections: str = "") -> Path:
    path = folder / "t.yaml"
    indented = "\n".join(f"  {line}" for line in tree.strip().splitlines())
    path.write_text(f"task: t\n{sections}tree:\n{indented}\n")
    return path


@pytest.mark.parametrize(
    ("tree", "location", "message"),
    [
        ('equals: {value: "{key}", to: a}', "4:3", "read '{key}' as something else"),
        ("sequence:\n  - set: {k: it's}\n  - say: {text: $k}", "5:7", "a script cannot write"),
    ],
)
def test_what_the_xml_cannot_say_in_a_node_is_refused_where_it_stands(
    tmp_path, tree, location, message
):
    path = write(tmp_path, tree)
    path.write_text(path.read_text().replace("task: t\n", "task: t\ndescription: d\n"))
    with pytest.raises(TaskFileError) as refused:
        exported(path)
    assert str(refused.value).startswith(f"{path}:{location}: ")
    assert message in str(refused.value)


def test_a_key_with_the_name_of_a_pose_is_refused(tmp_path):
    poses = "poses: {home: {base: [0, 0], heading_deg: 0}}\n"
    tree = "sequence:\n  - set: {home: 3}\n  - equals: {value: $home, to: 3}"
    path = write(tmp_path, f"{tree}\n  - drive: {{to: home}}", poses)
    with pytest.raises(TaskFileError, match=r":5:7: `home` is a key and a pose"):
        exported(path)


def test_seconds_become_whole_milliseconds_whatever_their_rounding(tmp_path):
    for seconds in ("2.3", "0.1", "1.1", "600", "0.001"):
        text = exported(write(tmp_path, f"timeout_s: {seconds}\nopen_gripper:"))
        assert f'<Timeout msec="{round(1000 * float(seconds))}">' in text
    text = exported(write(tmp_path, "timeout_s: 0.0015\nopen_gripper:"))
    assert '<timeout_s value="0.0015">' in text


@pytest.mark.parametrize("name", ["Sequence", "grasp"])
def test_a_name_that_the_xml_needs_itself_is_refused(tmp_path, name):
    path = write(tmp_path, "open_gripper:" if name != "grasp" else "grasp: {within: r}")
    text = path.read_text().replace("task: t", f"task: {name}")
    path.write_text(text + "regions: {r: {centre: [0, 0, 0], size: [1, 1, 1]}}\n")
    with pytest.raises(TaskFileError, match="taken"):
        exported(path)
