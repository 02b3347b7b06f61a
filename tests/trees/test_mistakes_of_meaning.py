"""What is written well and cannot be meant is told where it stands, with a hint."""

from __future__ import annotations

import pytest
from mistakes import file_with, found_in, marked

from config import Severity

ERRORS = (
    ("parallel: [drive: {to: door}, ¦navigate: {to: above}]", "both move the robot"),
    ("parallel: [drive: {to: door}, ¦recover: {arm: ready}]", "`drive` and `recover`"),
    ("parallel: [move_arm: {to: folded}, ¦move_arm: {to: ready}]", "one run after the other"),
    (
        "parallel:\n    - sequence: [wait: {duration_s: 3}, drive: {to: door}]\n"
        "    - ¦fallback: [arm_healthy, move_arm: {to: folded}]",
        "`drive` and `move_arm`",
    ),
    (
        "parallel: {policy: any, children: [follow: {within: box}, ¦look_at: {at: box}]}",
        "`follow` and `look_at`",
    ),
    ("¦equals: {value: $count, to: six}", "compares a number (`value`) with a text (`to`)"),
    ("¦equals: {value: $count, to: '3'}", "without quotes for a number"),
    ("¦equals: {value: $word, to: 6}", "a text (`value`) with a number"),
    ("¦equals: {value: true, to: 1}", "a truth value (`value`) with a number"),
    ("¦equals: {value: 3, to: three}", "which are never equal"),
    ("at_least: {value: $word, least: ¦1}", ""),
    ("¦say: {text: 'I saw {count}'}", "`{count}` in the text is filled by nothing"),
    ("¦say: {text: 'I saw {value}'}", "has only one of {value} and `value`"),
    ("¦say: {text: 'I saw', value: $count}", "has only one of {value} and `value`"),
    ("¦say: {text: '{value} of {all}', value: $count}", "`{all}` in the text"),
    ("¦say: {text: 'nothing in {}'}", "`{}` in the text"),
    ("¦drive:", "say either where `to`, or how far"),
    ("¦drive: {to: door, forward_m: 1}", "say either where `to`, or how far"),
    ("¦drive: {forward_m: 0}", "say either where `to`, or how far"),
    ("¦selector: [open_gripper]", "unknown node `selector`; write `fallback`"),
    ("¦Selector: [open_gripper]", "write `fallback`"),
    ("¦inverter: arm_healthy", "`invert: true`"),
    ("¦if: arm_healthy", "`unless` or `while`"),
    ("¦loop: [open_gripper]", "`forever`, `until`, or the modifier `repeat`"),
    ("¦or: [arm_healthy]", "write `any_of`"),
    ("¦and: [arm_healthy]", "write `all_of`"),
    ("¦sleep: {duration_s: 3}", "write `wait`"),
    ("¦include: {file: part.yaml}", "write `subtree`"),
    ("¦guard: arm_healthy", "the modifier `while`"),
    ("wait: {duration_s: ¦'${count}'}", "write `$count`"),
    ("wait: {duration_s: ¦$count + 1}", "nothing is computed in a task"),
    ("wait: {duration_s: ¦$count*2}", "nothing is computed in a task"),
    ("wait: {duration_s: ¦2 * 3}", "nothing is computed in a task"),
    ("wait: {duration_s: ¦5 s}", "write 5 alone: the unit stands in the name"),
    ("drive: {turn_deg: ¦90°}", "write 90 alone"),
    ("grasp: {within: box, force_n: ¦20 N}", "write 20 alone"),
    ("battery_above: {percent: ¦20 %}", "write 20 alone"),
    ("while: ¦[arm_healthy, holding_object]\n  open_gripper:", "all_of: [...]"),
    ("unless: ¦[holding_object]\n  open_gripper:", "`any_of`"),
    ("while: {¦open_gripper: }\n  drive: {to: door}", "is not one; write one of"),
    ("while: {all_of: [¦open_gripper]}\n  drive: {to: door}", "`all_of` asks a condition"),
    ("while: {not: {all_of: [¦wait: {duration_s: 1}]}}\n  drive: {to: door}", "`all_of` asks"),
    ("all_of: [¦drive: {to: door}]", "`all_of` asks a condition, and `drive` is not one"),
    ("any_of: [¦sequence: [arm_healthy]]", "and `sequence` is not one"),
    ("¦not: [arm_healthy, holding_object]", "`not` takes one condition, got 2"),
    ("¦all_of: []", "is empty"),
    ("all_of: [{¦arm_healthy: , invert: true}]", "`not` asks for the opposite"),
    ("¦any_of:", "is empty"),
)
FORM = (
    ("say: {text: saw¦: a cup}", "quote text that contains `: `"),
    ("open_gripper\n  retry: 3¦", ""),
)
WARNINGS = (
    ("¦drive: {to: door}\n  retry: 3\n  while: arm_healthy", "ends all attempts of `drive`"),
    ("¦wait: {duration_s: 5}\n  timeout_s: 3", "`timeout_s: 3` is over before `wait`"),
    ("¦wait: {duration_s: 5}\n  timeout_s: 5", "it waits for 5 s"),
    (
        "¦sequence: [wait: {duration_s: 2}, wait: {duration_s: 2}]\n  timeout_s: 3",
        "it waits for 4 s",
    ),
    ("¦parallel: [wait: {duration_s: 2}, wait: {duration_s: 4}]\n  timeout_s: 3", "for 4 s"),
    ("¦sequence: [{wait: {duration_s: 1}, repeat: 5}]\n  timeout_s: 3", "it waits for 5 s"),
    ("¦sequence: [{delay_s: 5, open_gripper: }]\n  timeout_s: 3", "it waits for 5 s"),
    ("¦forever: {force_failure: true, drive: {to: door}}", "`forever` cannot succeed"),
    (
        "¦until: [{force_failure: true, arm_healthy: }, open_gripper]",
        "`until` cannot succeed: `arm_healthy` never does",
    ),
)
FINE = (
    "parallel: [drive: {to: door}, say: {text: hello}]",
    "parallel: [drive: {to: door}, wait: {duration_s: 1}, open_gripper]",
    "fallback: [wait: {duration_s: 5}, open_gripper]\n  timeout_s: 3",
    "parallel: {policy: any, children: [wait: {duration_s: 5}, open_gripper]}\n  timeout_s: 3",
    "wait: {duration_s: 3}\n  timeout_s: 5",
    "drive: {to: door}\n  while: {all_of: [arm_healthy, {not: holding_object}]}",
    "equals: {value: $count, to: 3.0}",
    "say: {text: 'no blank here'}",
    "forever: {retry: 2, grasp: {within: box}}",
)


@pytest.mark.parametrize(("item", "why"), ERRORS, ids=[item for item, _ in ERRORS])
def test_what_cannot_be_meant_is_refused(tmp_path, item, why):
    text = file_with(item=f"- {item}")
    found = found_in(tmp_path, text)
    assert why in str(found[0])
    assert found[0].hint
    assert len(found) == 1
    if why:
        assert (found[0].location.line, found[0].location.column) == marked(text)


@pytest.mark.parametrize(("item", "why"), FORM, ids=[item for item, _ in FORM])
def test_what_is_no_yaml_is_refused(tmp_path, item, why):
    [found] = found_in(tmp_path, file_with(item=f"- {item}"))
    assert "this is not YAML" in found.message
    assert why in found.hint


@pytest.mark.parametrize(("item", "why"), WARNINGS, ids=[item for item, _ in WARNINGS])
def test_what_is_probably_not_meant_is_warned_of(tmp_path, item, why):
    text = file_with(item=f"- {item}")
    assert found_in(tmp_path, text) == []
    [found] = found_in(tmp_path, text, Severity.WARNING)
    assert (found.location.line, found.location.column) == marked(text)
    assert why in str(found)


@pytest.mark.parametrize("item", FINE)
def test_what_can_be_meant_is_good(tmp_path, item):
    text = file_with(item=f"- {item}")
    assert found_in(tmp_path, text) == []
    assert found_in(tmp_path, text, Severity.WARNING) == []
