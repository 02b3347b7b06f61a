"""Every error is reported at its location, with a hint."""

from __future__ import annotations

import pytest
from toy_task import FIRST, HEAD, TREE, errors

TREE_MISTAKES = {
    "unknown node": (
        "- navigte: {to: home}",
        "0:3: unknown node `navigte`; did you mean `navigate`?",
    ),
    "unknown node unlike any": (
        "- zzz",
        "0:3: unknown node `zzz`; known: `add`, `all_of`, `any_of`, `ask`, `count`, `fallback`, "
        "`for_each`, `forever`, `grasp`, `navigate`, `not`, `note`, `open_gripper`, `parallel`, "
        "`place`, `play`, `reactive_fallback`, `reactive_sequence`, `recover`, `region_empty`, "
        "`resuming_sequence`, `retreat_check`, `sequence`, `set`, `subtree`, `switch`, `until`",
    ),
    "unknown parameter": (
        "- grasp: {within: box, lock_distance: 0.2}",
        "0:24: `grasp` has no parameter `lock_distance`; did you mean `lock_distance_m`?",
    ),
    "parameter of a leaf without any": (
        "- open_gripper: {wide: true}",
        "0:18: `open_gripper` has no parameter `wide`; it takes none: remove it",
    ),
    "modifier below a leaf": (
        "- grasp: {within: box, retry: 3}",
        "0:24: `grasp` has no parameter `retry`; `retry` belongs beside `grasp`, not below it",
    ),
    "parameter beside a leaf": (
        "- navigate:\n  to: home",
        "1:3: `to` stands beside `navigate`, and is a parameter of it; indent it below `navigate:`",
    ),
    "unknown modifier": (
        "- open_gripper:\n  retyr: 3",
        "1:3: unknown key `retyr` beside `open_gripper`; did you mean `retry`?",
    ),
    "missing parameter": (
        "- navigate",
        "0:3: `navigate` lacks `to` (a tool pose or a base pose: where the hand or the base goes);"
        " write `navigate: {to: ...}` (known: `dock`, `home`)",
    ),
    "wrong type": (
        "- navigate: {to: home, timeout_s: soon}",
        "0:35: `timeout_s` (give up after this [s]): expected a number, got the text `soon`;"
        " write a number",
    ),
    "not one of the choices": (
        "- grasp: {within: box, side: middle}",
        "0:30: `side`: expected `left` or `right`, got the text `middle`; write `left` or `right`",
    ),
    "infinite number": (
        "- navigate: {to: home, timeout_s: .inf}",
        "0:35: `timeout_s` (give up after this [s]): expected a number, got the number `inf`;"
        " write a finite number",
    ),
    "list for a value": (
        "- grasp: {within: [box]}",
        "0:19: `within` (where to look): expected a region, got a list; write a single value",
    ),
    "scalar for parameters": (
        "- grasp: box",
        "0:10: `grasp` takes a mapping of parameters, not the text `box`;"
        " write `grasp: {within: ...}` (known: `box`)",
    ),
    "unknown pose": (
        "- navigate: {to: hme}",
        "0:18: `to` (where the hand or the base goes): no tool pose or base pose is called `hme`;"
        " did you mean `home`? (known: `dock`, `home`)",
    ),
    "pose of the wrong kind": (
        "- navigate: {to: folded}",
        "0:18: `to` (where the hand or the base goes): `folded` is a posture,"
        " expected a tool pose or a base pose; known: `dock`, `home`",
    ),
    "two nodes in an item": (
        "- open_gripper:\n  retreat_check:",
        "1:3: two nodes in one item: `open_gripper` and `retreat_check`;"
        " begin each with its own `- ` in the list of a composite",
    ),
    "no node in an item": (
        "- name: pick",
        "0:3: this item has no node; add a node key, for example `add`, `all_of`, `any_of`",
    ),
    "list for a node": (
        "- [open_gripper]",
        "0:3: expected a node, got a list;"
        " write `sequence:` above a list, and `node: {...}` for a single node",
    ),
    "empty composite": (
        "- fallback:",
        "0:3: `fallback` is empty; add a node below it, or remove it",
    ),
    "children without a list": (
        "- sequence:\n    open_gripper:",
        "1:5: the children of `sequence` are a list, not a mapping; begin each child with `- `",
    ),
    "question without work": (
        "- until: [open_gripper]",
        "0:3: `until` needs at least 2 children, got 1; give it a question, then the work to do",
    ),
    "forever with two": (
        "- forever: [open_gripper, retreat_check]",
        "0:3: `forever` takes one node, got 2; put them in a `sequence:` below it",
    ),
    "unusable name": (
        "- open_gripper:\n  name: a/b",
        "1:9: `name` cannot be the text `a/b`; write a line of text without `/`",
    ),
    "parameter of the wrong type": (
        "- open_gripper:\n  retry: $speed",
        "1:10: `retry`: expected a whole number of at least 1 and at most 100000, got the"
        " number `1.5`, the value of `$speed`; write a whole number of at least 1 and"
        " at most 100000",
    ),
    "unknown task parameter": (
        "- open_gripper:\n  retry: $cuont",
        "1:10: the task has no parameter `cuont`; did you mean `count`?",
    ),
    "dollar without a name": (
        "- play: {script: $5}",
        "0:18: `$5` begins with `$` and is neither a parameter nor a key; write `$` and its name",
    ),
}


@pytest.mark.parametrize(("item", "message"), TREE_MISTAKES.values(), ids=TREE_MISTAKES)
def test_mistake_in_the_tree(tmp_path, item, message):
    indented = "\n".join(f"    {line}" for line in item.splitlines())
    # Messages count lines from the item, and columns as if it were not indented.
    line, column, text = message.split(":", 2)
    expected = f"{FIRST + 1 + int(line)}:{4 + int(column)}:{text}"
    assert errors(tmp_path, f"{HEAD}  sequence:\n{indented}\n") == [expected]


def test_a_message_is_one_line_whatever_it_quotes(tmp_path):
    [found] = errors(tmp_path, 'task: "a\\n\\e[31m b' + "c" * 1000 + '"\ntree: open_gripper\n')
    assert found.startswith("1:7: task: `a [31m bccc")
    assert found.isprintable()
    assert len(found) < 600


FILE_MISTAKES = {
    "no task": (TREE, "1:1: the file lacks `task`; add `task`"),
    "no tree": ("task: toy\n", "1:1: the file lacks `tree`; add `tree`"),
    "unknown section": (
        "task: toy\npose: {}\n" + TREE,
        "2:1: the file has no key `pose`; did you mean `poses`?",
    ),
    "a list": ("- a", "1:1: the file is a mapping, not a list; write `task`, `tree` with their"),
    "task name": (
        "task: ../x\n" + TREE,
        "1:7: task: `../x` is not a name; use letters, digits and `_`, and begin with a letter",
    ),
    "task number": ("task: 5\n" + TREE, "1:7: task: expected text, got the number `5`; write text"),
    "poses as a list": (
        "task: toy\nposes: [a]\n" + TREE,
        "2:8: `poses` is a mapping of names, not a list; indent `name: ...` below `poses:`",
    ),
    "pose without anything": (
        "task: toy\nposes:\n  a:\n" + TREE,
        "3:3: poses.a: is empty; write one of `xyz` and `rpy_deg`,"
        " `base` and `heading_deg`, `joints_deg`",
    ),
    "pose of two kinds": (
        "task: toy\nposes: {a: {xyz: [0, 0, 0], base: [0, 0]}}\n" + TREE,
        "2:9: poses.a: mixes forms of pose; write one of `xyz` and",
    ),
    "pose in other units": (
        "task: toy\nposes: {a: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0], rpy: 1}}\n" + TREE,
        "2:49: poses.a.rpy: unknown key; did you mean `rpy_deg`?",
    ),
    "too few numbers": (
        "task: toy\nposes: {a: {joints_deg: [0, 0]}}\n" + TREE,
        "2:25: poses.a.joints_deg: expected 7 values, got 2; write 7 values",
    ),
    "too large a number": (
        "task: toy\nposes: {a: {base: [0, 1e999], heading_deg: 0}}\n" + TREE,
        "2:23: poses.a.base.1: expected a finite number, got the number `inf`; write a finite",
    ),
    "redefined posture": (
        "task: toy\nposes: {ready: {base: [0, 0], heading_deg: 0}}\n" + TREE,
        "2:9: `ready` is built in and cannot be redefined; choose another name",
    ),
    "flat region": (
        "task: toy\nregions: {a: {centre: [0, 0, 0], size: [1, 0, 1]}}\n" + TREE,
        "2:44: regions.a.size.1: an edge is not positive; give the full length of each edge [m]",
    ),
    "region called as a pose": (
        "task: toy\nposes: {a: {base: [0, 0], heading_deg: 0}}\n"
        "regions: {a: {centre: [0, 0, 0], size: [1, 1, 1]}}\n" + TREE,
        "3:11: `a` is a pose already, on line 2; choose another name",
    ),
    "name with a blank": (
        "task: toy\nposes: {a b: {base: [0, 0], heading_deg: 0}}\n" + TREE,
        "2:9: `a b` cannot be a name in `poses`; use letters, digits and `_`,",
    ),
    "parameter without a default": (
        "task: toy\nparams: {a: {description: x}}\ntree: {open_gripper: , retry: $a}\n",
        "2:10: params.a: has neither `type` nor `default`; add a `default`, or a `type`",
    ),
}


@pytest.mark.parametrize(("text", "message"), FILE_MISTAKES.values(), ids=FILE_MISTAKES)
def test_mistake_in_the_file(tmp_path, text, message):
    [found] = errors(tmp_path, text)
    assert found.startswith(message)
