"""The section `params`: types, defaults, bounds, choices, and values from outside."""

from pathlib import Path

import pytest
from mistakes import table
from tree_toys import TOYS, check

from trees.language import TaskFileError, load

TASK = (Path(__file__).parent / "parameters.yaml").read_text("utf-8")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "t.yaml"


GIVEN = {"count": "5", "far": "2", "side": "left", "word": "10", "goal": "home"}


def test_a_parameter_has_its_default_or_a_value_from_outside_and_its_type(path):
    path.write_text(TASK)
    task, given = (load(path, leaves=TOYS, overrides=values) for values in ({}, GIVEN))
    assert task.warnings == ()
    values = {name: parameter.value for name, parameter in task.parameters.items()}
    assert values["far"] == 1.0
    assert isinstance(values["far"], float)
    assert (values["goal"].name, values["where"].name) == ("home", "box")
    assert task.parameters["count"].description == "how often"
    assert str(task.parameters["count"].type) == "a whole number of at least 1 and at most 5"
    assert dict(task.root.children[0].modifiers) == {"retry": 3}
    others = [given.parameters[name].value for name in ("count", "far", "side", "word")]
    assert others == [5, 2.0, "left", "10"]


@table("overrides")
def test_values_from_outside_that_do_not_fit(path, row):
    path.write_text(TASK)
    name, _, value = row["task"].partition("=")
    with pytest.raises(TaskFileError) as raised:
        load(path, leaves=TOYS, overrides={name: value})
    [diagnostic] = raised.value.diagnostics
    assert str(diagnostic).removeprefix(f"{path}:").startswith(row["tells"])


@table("parameters")
def test_definitions_that_are_not_sound_are_one_mistake_each(path, row):
    path.write_text(
        f"task: toy\nparams: {{a: {row['task']}}}\n"
        "tree: {sequence: [navigate: {to: $a}, note: {value: $a}, {retry: $a, open_gripper: }]}\n"
    )
    found = [str(diagnostic).removeprefix(f"{path}:") for diagnostic in check(path, leaves=TOYS)]
    assert row["tells"] in found[0]


def test_a_parameter_without_a_value_is_asked_for(path):
    path.write_text(
        "task: toy\nparams: {a: {type: int, description: how many}}\n"
        "tree: {retry: $a, open_gripper: }\n"
    )
    assert check(path, leaves=TOYS) == []
    with pytest.raises(TaskFileError) as raised:
        load(path, leaves=TOYS)
    assert str(raised.value).removeprefix(f"{path}:") == (
        "2:10: the parameter `a` has no value (a whole number: how many);"
        " give `-p a=...`, or a `default` here"
    )
    assert load(path, leaves=TOYS, overrides={"a": "2"}).root.modifiers == {"retry": 2}


def test_poses_are_numbers_and_take_no_parameters(path):
    path.write_text(
        "task: toy\nparams: {x: {default: 2.5}, p: {type: pose, default: a}}\n"
        "poses: {a: {base: [$x, 0], heading_deg: $x}, b: {base: [1, 0], heading_deg: 0}}\n"
        "regions: {r: {centre: [0, 0, $x], size: [1, 1, 1]}}\n"
        "tree:\n  sequence:\n    - navigate: {to: $p}\n    - navigate: {to: b}\n"
        "    - {retry: $x, grasp: {within: r}}\n"
    )
    found = [str(diagnostic).removeprefix(f"{path}:") for diagnostic in check(path, leaves=TOYS)]
    assert found[0] == (
        "3:20: poses.a: `$x` stands in place of a number; write numbers here, and choose among"
        " poses by a parameter of type `pose`"
    )
    assert found[1].startswith("4:30: regions.r: `$x` stands in place of a number; ")
    assert "`p`: no tool pose" not in str(found)
    assert "`retry`: expected a whole number" in found[-1]
