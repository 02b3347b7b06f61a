"""What cannot be meant is refused where it stands (`¦`), and what hardly is, is warned of.

Mistakes of form and names are in the folder `broken`.
"""

from __future__ import annotations

import pytest
from mistakes import file_with, found_in, marked

from config import Severity

LIST = "- detect: {region: box, list: things}\n"
ERRORS = (
    # numbers
    ("- navigate: {to: above, speed_m_s: ¦-1}", "at least 0.01 and at most 2"),
    ("- navigate: {to: above, within_m: ¦40}", "did you mean 0.04 (from millimetres) or 0.4"),
    ("- navigate: {to: above, timeout_s: ¦1e6}", "did you mean 1000 (from milliseconds"),
    ("- drive: {forward_m: ¦-300}", "did you mean -0.3 (from millimetres"),
    ("- drive: {turn_deg: ¦1.57}", "did you mean 90? Else write 1.6"),
    ("- scan_for_objects: {region: box, count: n, frames: ¦2.5}", "a whole number"),
    ("- scan_for_objects: {region: box, count: n, smallest_cm2: ¦90000}", "did you mean 900 ("),
    ("- battery_above: {percent: ¦0.2}", "did you mean 20 (from a share)?"),
    ("- grasp: {within: box, min_width_mm: ¦0.04}", "did you mean 40 (from metres)?"),
    ("- open_gripper:\n  cooldown_s: ¦1e9", "at most 604800"),
    ("poses: {a: {xyz: [¦2935, 0, 0.85], rpy_deg: [180, 0, 0]}}", "did you mean 2.935 ("),
    ("poses: {a: {xyz: [2, 0, 1], rpy_deg: [¦3.14, 0, 0]}}", "radians; did you mean 180?"),
    ("poses: {a: {base: [0, 1], heading_deg: ¦540}}", "more than a turn"),
    ("regions: {a: {centre: [0, 0, 0], size: [¦400, 1, 0.2]}}", "did you mean 0.4 ("),
    ("regions: {a: {centre: [0, 0, 0], size: [¦12, 1, 0.2]}}", "longer than 10 m"),
    ("regions: {a: {centre: [0, 0, 0], size: [¦0, 1, 0.2]}}", "not positive"),
    # two movers at a time
    ("- parallel: [drive: {to: door}, ¦navigate: {to: above}]", "both move the robot"),
    (
        "- parallel:\n    - sequence: [wait: {duration_s: 3}, drive: {to: door}]\n"
        "    - ¦fallback: [arm_healthy, move_arm: {to: folded}]",
        "`drive` and `move_arm`",
    ),
    # values that never fit
    ("- ¦equals: {value: $count, to: six}", "compares a number (`value`) with a text (`to`)"),
    ("- ¦equals: {value: true, to: 1}", "a truth value (`value`) with a number"),
    ("- sequence: [set: {v: true}, ¦equals: {value: $v, to: 1}]", "which are never equal"),
    ("- ¦say: {text: 'I saw {count}'}", "`{count}` in the text is filled by nothing"),
    ("- ¦say: {text: 'I saw', value: $count}", "has only one of {value} and `value`"),
    ("- ¦drive: {to: door, forward_m: 1}", "say either where `to`, or how far"),
    ("- wait: {duration_s: ¦$count + 1}", "nothing is computed in a task"),
    ("- ¦selector: [open_gripper]", "unknown node `selector`; write `fallback`"),
    # conditions
    ("- while: {all_of: [¦open_gripper]}\n  drive: {to: door}", "`all_of` asks a condition"),
    ("- any_of: [¦sequence: [arm_healthy]]", "and `sequence` is not one"),
    ("- ¦not: [arm_healthy, holding_object]", "`not` takes one condition, got 2"),
    ("- all_of: [{¦arm_healthy: , invert: true}]", "`not` asks for the opposite"),
    # keys, values and cases
    ("- ¦add: {}", "`add` names no key"),
    ("- add: {¦tries: 1}", "`$tries` is neither a parameter nor a key that is written before"),
    ("- sequence: [set: {k: six}, add: {¦k: 1}]", "expected a whole number or a number, got `$k`"),
    ("- sequence: [set: {k: 0}, add: {¦k: 0.5}]", "begin with `set: {k: 0.0}`"),
    ("- sequence: [set: {k: 0}, add: {k: ¦more}]", "`add` cannot add the text `more`"),
    ("- for_each: ¦{item: x, in: [box]}", "`for_each` lacks `do`"),
    ("- for_each: {item: x, in: ¦[], do: open_gripper}", "`in` has 0 values"),
    ("- for_each: {item: ¦count, in: [box], do: open_gripper}", "`count` is a parameter"),
    ("- for_each: {item: x, in: [box, ¦3], do: {grasp: {within: $x}}}", "of several kinds"),
    ("- for_each: {item: x, in: [¦$k], do: {grasp: {within: $x}}}", "known before the run"),
    ("- for_each: {item: x, in: [folded], do: {grasp: {within: ¦$x}}}", "the posture `folded`"),
    ("- switch: ¦{value: $count}", "`switch` lacks `cases`"),
    ("- switch: {value: $count, cases: ¦{}}", "values to nodes, not empty"),
    ("- switch: {value: $count, cases: {¦3: open_gripper}}", "write it in quotes"),
    ("- switch: {value: ¦$k, cases: {a: open_gripper}}", "`$k` is neither a parameter nor a key"),
    # detected objects
    ("- grasp: {within: box, choose: ¦larges}", "; did you mean `largest`?"),
    (
        "- ¦grasp: {within: box, min_width_mm: 60, max_width_mm: 20}",
        "a least width of 60 mm and a largest of 20 mm, between which nothing is; exchange",
    ),
    (
        "- ¦grasp: {within: box, neighbour: true, choose: best}",
        "`grasp` takes a neighbour, and nothing says of which object; add `choose: largest`",
    ),
    (LIST + "- grasp: {within: ¦$things}", "`$things`, which is a list of detected obj"),
    (
        LIST + "- for_each: {item: o, in: $things, do: {¦grasp: {within: $o, choose: largest}}}",
        "chooses by `choose` among one object, that of `within`; leave it out",
    ),
    (
        LIST + "- for_each: {item: o, in: $things, do: {place: {on: ¦$o}}}",
        "got `$o`, which is a detected object",
    ),
    ("- ¦place: {}", "`place` is given no place; give one of `on`, `at` and `onto`"),
    ("- ¦place: {on: box, onto: box}", "is given all of on, onto; give one"),
    ("- ¦place: {onto: box, pitch_m: 0.1}", "`pitch_m`, which belongs to `on`; leave it out"),
    ("- ¦time_between: {after: 8:00, before: 12:00}", "the time `8:00`; write hours and min"),
    ("- ¦snapshot: {file: a/b}", "has the file name `a/b`; write at most 60 letters"),
    (
        LIST + "- for_each: {item: o, in: ¦things, do: {look_at: {at: $o}}}",
        "not the text `things`; write `$things` if that is its key",
    ),
    (
        LIST + "- for_each: {item: o, in: $things, do: {look_at: {at: $o}}}\n"
        "- grasp: {within: ¦$o}",
        "`$o` is not written on every way here",
    ),
    (
        LIST + "- for_each: {item: o, in: $things, do: {¦looks_like: {object: $o}}}",
        "`looks_like` asks nothing of its object; add `colour`",
    ),
)
WARNINGS = (
    ("- ¦drive: {to: door}\n  retry: 3\n  while: arm_healthy", "ends all attempts of `drive`"),
    ("- ¦forever: {force_failure: true, drive: {to: door}}", "`forever` cannot succeed"),
    (
        "- ¦until: [{force_failure: true, arm_healthy: }, open_gripper]",
        "`until` cannot succeed: `arm_healthy` never does",
    ),
    ("- for_each: {item: ¦x, in: [box], do: open_gripper}", "the item `x` is never used"),
)
FINE = (
    "- parallel: [drive: {to: door}, wait: {duration_s: 1}, open_gripper]",
    "- drive: {to: door}\n  while: {all_of: [arm_healthy, {not: holding_object}]}",
    "- equals: {value: $count, to: 3.0}",
    *(f"- drive: {{turn_deg: {angle}}}" for angle in (0.3, 1.6, 3.1, 90, -1)),
)


@pytest.mark.parametrize(("mistake", "why"), ERRORS, ids=[row[0] for row in ERRORS])
def test_what_cannot_be_meant_is_refused_where_it_stands(tmp_path, mistake, why):
    text = file_with(mistake)
    [found] = found_in(tmp_path, text)
    assert (found.location.line, found.location.column) == marked(text)
    assert why in str(found)
    assert found.hint


@pytest.mark.parametrize(("item", "why"), WARNINGS, ids=[row[0] for row in WARNINGS])
def test_what_is_probably_not_meant_is_warned_of(tmp_path, item, why):
    text = file_with(item)
    assert found_in(tmp_path, text) == []
    [found] = found_in(tmp_path, text, Severity.WARNING)
    assert (found.location.line, found.location.column) == marked(text)
    assert why in str(found)


@pytest.mark.parametrize("item", ["", *FINE])
def test_what_can_be_meant_is_good(tmp_path, item):
    text = file_with(item)
    assert found_in(tmp_path, text) == []
    assert found_in(tmp_path, text, Severity.WARNING) == []


def test_a_case_that_its_parameter_never_has_is_refused(tmp_path):
    text = file_with("- switch: {value: $side, cases: {¦lfet: open_gripper}}")
    text = text.replace("params:\n", "params:\n  side: {type: [left, right], default: left}\n")
    [found] = found_in(tmp_path, text)
    assert (found.location.line, found.location.column) == marked(text)
    assert str(found).endswith("`$side` is never `lfet`; did you mean `left`?")


def test_values_within_values_are_bounded(tmp_path):
    numbers = ", ".join(str(number) for number in range(100))
    inner = f"for_each: {{item: b, in: [{numbers}], do: {{wait: {{duration_s: $b}}}}}}"
    text = file_with(f"- ¦for_each: {{item: a, in: [{numbers}], do: {{{inner}}}}}")
    found = found_in(tmp_path, text)
    assert "more than 1000 nodes" in str(found[0])
