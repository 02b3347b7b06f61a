"""Trees made of several files: parameters in, outputs out, circles, links, and how many."""

import shutil
from pathlib import Path

import pytest
from mistakes import table
from tree_toys import TOYS, ToyContext, check

from trees.language import TaskFileError, build, load, nodes_in_order


@pytest.fixture
def folder(tmp_path):
    return write_files(tmp_path)


def test_a_subtree_runs_with_its_own_values_and_hands_out_its_outputs(folder):
    task = load(folder / "top.yaml", leaves=TOYS)
    context = ToyContext()
    root = build(task, context)
    assert nodes_in_order(root)[4].path == "sequence/part/sequence/retry/navigate"
    for _ in range(3):
        root.tick_once()
    assert root.children[0].children[0].children[0].children[0].to.name == "home"
    begun = [event for event in context.events if "begins" in event]
    assert begun == ["note begins with 1.0", "note begins with 2.0"]
    first, again = task.root.children[:2]
    assert (first.name, again.name) == ("part", "again")
    assert first.task.parameters["times"].value == 2
    assert again.task.parameters["times"].value == 5
    assert task.files == (folder / "top.yaml", folder / "parts/part.yaml")


def test_keys_cross_the_border_by_value_at_the_start_and_at_the_success(tmp_path):
    task = load(write_files(tmp_path, "crossing") / "top.yaml", leaves=TOYS)
    context = ToyContext()
    root = build(task, context)
    for _ in range(5):
        root.tick_once()
    begun = [event for event in context.events if "begins" in event]
    assert begun == [f"note begins with {value}" for value in (7.0, 7.0, 7.0, 2.0)]


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
    part = "task: part\nparams: {times: {type: int}, few: {type: int, max: 3}}\n"
    part += "tree: {retry: $times, note: {value: $few}}\n"
    with_keys = "subtree: {file: parts/part.yaml, with: {times: $n, few: $n}}"
    top = f"task: top\ntree:\n  sequence:\n    - set: {{n: 2}}\n    - {with_keys}\n"
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
    part = "task: p\nparams: {n: {type: int, max: 3}}\ntree: {retry: $n, open_gripper: }\n"
    top = "task: top\nparams: {n: {type: int}}\n"
    top += "tree: {subtree: {file: parts/part.yaml, with: {n: $n}}}\n"
    assert errors(folder, top, part) == []
    task = load(folder / "top.yaml", leaves=TOYS, overrides={"n": "2"})
    assert task.root.task.root.modifiers == {"retry": 2}
    [found] = errors(folder, top.replace("int", "text"), part)
    assert "expected a whole number of at most 3, got `$n`, which is text" in found


FILES = Path(__file__).parent / "two_files"


TOP, PART = ((FILES / name).read_text("utf-8") for name in ("top.yaml", "parts/part.yaml"))


def write_files(folder: Path, files: str = "two_files") -> Path:
    return Path(shutil.copytree(FILES.with_name(files), folder, dirs_exist_ok=True))


def errors(folder, top: str = TOP, part: str = PART) -> list[str]:
    (folder / "top.yaml").write_text(top)
    (folder / "parts" / "part.yaml").write_text(part)
    found = check(folder / "top.yaml", leaves=TOYS)
    return [str(diagnostic).removeprefix(f"{folder}/") for diagnostic in found]


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
    modified = "{force: success, unless: {ask: {answers: F}}, while: {ask: {answers: S}}, "
    modified += "retry: 2, repeat: 2, timeout_s: 9, %s}"
    nest = "%s"
    for _ in range(7):
        nest %= modified % "forever: %s"
    (folder / "last.yaml").write_text(f"task: last\ntree: {nest % '{open_gripper: }'}\n")
    (folder / "top.yaml").write_text(f"task: top\ntree: {nest % '{subtree: {file: last.yaml}}'}\n")
    root = build(load(folder / "top.yaml", leaves=TOYS), ToyContext())
    root.tick_once()
    deeper = modified % f"forever: {nest % '{subtree: {file: last.yaml}}'}"
    [found] = errors(folder, f"task: top\ntree: {deeper}\n")
    assert found.startswith("last.yaml:2:")
    assert "the tree is more than 100 levels deep here, modifiers counted" in found
