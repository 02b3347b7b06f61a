"""Trees made of several files: parameters in, outputs out, and what is refused."""

import pytest
from mistakes import table
from subtree_files import errors, write_files
from tree_toys import TOYS, ToyContext

from trees.language import TaskFileError, build, check, load, nodes_in_order


@pytest.fixture
def folder(tmp_path):
    return write_files(tmp_path)


def test_a_subtree_runs_with_its_own_values_and_hands_out_its_outputs(folder):
    task = load(folder / "top.yaml", leaves=TOYS)
    context = ToyContext()
    root = build(task, context)
    assert [place.path for place in nodes_in_order(root)][:5] == [
        "sequence",
        "sequence/part",
        "sequence/part/sequence",
        "sequence/part/sequence/retry",
        "sequence/part/sequence/retry/navigate",
    ]
    for _ in range(3):
        root.tick_once()
    assert root.children[0].children[0].children[0].children[0].to.name == "home"
    assert [event for event in context.events if "begins" in event] == [
        "note begins with 1.0",
        "note begins with 2.0",
    ]
    first, again = task.root.children[:2]
    assert (first.name, again.name) == ("part", "again")
    assert first.task.parameters["times"].value == 2
    assert again.task.parameters["times"].value == 5
    assert [path.relative_to(folder).as_posix() for path in task.files] == [
        "top.yaml",
        "parts/part.yaml",
    ]


def test_keys_cross_the_border_by_value_at_the_start_and_at_the_success(folder):
    part = """\
task: part
params: {start: {type: int}, answer: {type: text}}
outputs: {end: the next number}
tree:
  sequence:
    - count: {times: end}
    - note: {value: $start}
    - ask: {answers: $answer}
"""
    top = """\
task: top
tree:
  sequence:
    - set: {n: 7}
    - fallback:
        - subtree: {file: parts/part.yaml, with: {start: $n, answer: F}, out: {end: n}}
        - note: {value: $n}
    - subtree: {file: parts/part.yaml, with: {start: $n, answer: S}, out: {end: n}}
    - note: {value: $n}
"""
    assert [line for line in errors(folder, top, part) if "warning" not in line] == []
    context = ToyContext()
    root = build(load(folder / "top.yaml", leaves=TOYS), context)
    for _ in range(5):
        root.tick_once()
    assert [event for event in context.events if "begins" in event] == [
        "note begins with 7.0",
        "note begins with 7.0",
        "note begins with 7.0",
        "note begins with 2.0",
    ]


@table("subtrees")
def test_a_subtree_that_is_not_as_it_should_be(folder, row):
    top = f"""\
task: top
poses: {{home: {{base: [1, 2], heading_deg: 0}}}}
tree:
  sequence:
    - {row["task"].replace("LONG", "x" * 300)}
    - navigate: {{to: home}}
"""
    [found] = [line for line in errors(folder, top) if "warning" not in line]
    assert row["tells"] in found


def test_a_part_can_be_checked_alone_and_not_be_built(folder):
    path = folder / "parts" / "part.yaml"
    assert check(path, leaves=TOYS) == []
    with pytest.raises(TaskFileError, match=r"3:3: the parameter `to` has no value \(a tool pose"):
        load(path, leaves=TOYS)
    task = load(path, leaves=TOYS, open_parameters=True)
    assert str(task.root.children[0].arguments["to"]) == "$to"
    with pytest.raises(TaskFileError, match=r"the parameter `to` has no value; give it one"):
        build(task, ToyContext())


def test_a_key_cannot_be_what_has_to_be_known_before_the_run(folder):
    part = """\
task: part
params: {times: {type: int}, few: {type: int, max: 3}}
tree: {retry: $times, note: {value: $few}}
"""
    top = """\
task: top
tree:
  sequence:
    - set: {n: 2}
    - subtree: {file: parts/part.yaml, with: {times: $n, few: $n}}
"""
    assert [line.split(";")[0] for line in errors(folder, top, part)] == [
        "top.yaml:5:63: `few` has bounds, and `$n` has its value only during the run",
        "parts/part.yaml:3:15: `retry` is fixed before the run, and `$times` is given a key",
    ]


def test_an_output_has_to_be_written_on_every_way_to_success(folder):
    part = "task: part\noutputs: {done: }\ntree: {fallback: [count: {times: done}, open_gripper]}\n"
    top = "task: top\ntree: {subtree: {file: parts/part.yaml}}\n"
    assert errors(folder, top, part) == [
        "parts/part.yaml:2:11: the tree can succeed without having written the output `done`;"
        " begin it with `set: {done: ...}`"
    ]
    part = "task: part\noutputs: {dne: }\ntree: {count: {times: done}}\n"
    assert "nothing in the tree writes the output `dne`; did you mean `done`?" in str(
        errors(folder, top, part)
    )


def test_an_open_parameter_may_be_handed_on_to_what_is_fixed_or_bounded(folder):
    part = (
        "task: part\nparams: {times: {type: int, max: 3}}\ntree: {retry: $times, open_gripper: }\n"
    )
    top = """\
task: top
params: {n: {type: int}}
tree: {subtree: {file: parts/part.yaml, with: {times: $n}}}
"""
    assert errors(folder, top, part) == []
    task = load(folder / "top.yaml", leaves=TOYS, overrides={"n": "2"})
    assert task.root.task.root.modifiers == {"retry": 2}
    [found] = errors(folder, top.replace("int", "text"), part)
    assert "expected a whole number of at most 3, got `$n`, which is text" in found
