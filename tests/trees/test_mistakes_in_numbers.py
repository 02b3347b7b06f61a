"""Numbers that cannot be meant are refused where they stand, with a hint: speeds, places, units."""

from __future__ import annotations

import pytest
from mistakes import file_with, found_in, marked

ITEMS = (
    ("navigate: {to: above, speed_m_s: ¦-1}", "at least 0.01 and at most 2"),
    ("navigate: {to: above, speed_m_s: ¦500}", "did you mean 0.5 (from millimetres"),
    ("navigate: {to: above, within_m: ¦40}", "did you mean 0.04 (from millimetres) or 0.4"),
    ("navigate: {to: above, timeout_s: ¦0}", "greater than 0"),
    ("navigate: {to: above, timeout_s: ¦1e6}", "did you mean 1000 (from milliseconds"),
    ("drive: {forward_m: ¦-300}", "did you mean -0.3 (from millimetres"),
    ("drive: {turn_deg: ¦1.57}", "did you mean 90? Else write 1.6"),
    ("drive: {turn_deg: ¦720}", "at most 360"),
    ("move_arm: {to: folded, tolerance_deg: ¦90}", "at most 45"),
    ("recover: {arm: ready, rise_m: ¦150}", "did you mean 0.15 (from millimetres"),
    ("retreat_check: {rise_m: ¦14}", "or 0.14 (from centimetres"),
    ("grasp: {within: box, force_n: ¦5000}", "at most 140"),
    ("grasp: {within: box, force_n: ¦0}", "at least 1"),
    ("grasp: {within: box, lock_distance_m: ¦250}", "did you mean 0.25 ("),
    ("place: {on: table, pitch_m: ¦0.0001}", "at least 0.02"),
    ("follow: {within: box, still_s: ¦-2}", "at least 0"),
    ("scan_for_objects: {region: box, count: n, frames: ¦1e9}", "a whole number"),
    ("scan_for_objects: {region: box, count: n, frames: ¦2.5}", "a whole number"),
    ("scan_for_objects: {region: box, count: n, smallest_cm2: ¦90000}", "did you mean 900 ("),
    ("wait: {duration_s: ¦-1}", "at least 0"),
    ("battery_above: {percent: ¦0.2}", "did you mean 20 (from a share)?"),
    ("near: {pose: above, within_deg: ¦200}", "at most 180"),
    ("near: {pose: above, within_deg: ¦0.524}", "did you mean 30? Else write 0.5"),
    ("- open_gripper:\n  cooldown_s: ¦1e9", "at most 604800"),
    ("- open_gripper:\n  retry: ¦0", "at least 1"),
    ("- open_gripper:\n  repeat: ¦2.5", "a whole number"),
    ("- parallel: {policy: ¦0, children: [open_gripper, arm_healthy]}", "at least 1"),
)
POSES = (
    ("a: {xyz: [¦2935, 0, 0.85], rpy_deg: [180, 0, 0]}", "did you mean 2.935 ("),
    ("a: {xyz: [2.9, 0, ¦850], rpy_deg: [180, 0, 0]}", "did you mean 0.85 ("),
    ("a: {xyz: [2.9, 0, 0.85], rpy_deg: [¦3.14, 0, 0]}", "looks like radians; did you mean 180?"),
    ("a: {xyz: [2.9, 0, 0.85], rpy_deg: [180, 0, ¦1.571]}", "did you mean 90?"),
    ("a: {xyz: [2.9, 0, 0.85], rpy_deg: [180, 0, ¦7200]}", "more than a turn"),
    ("a: {base: [0, ¦1600], heading_deg: 0}", "did you mean 1.6 ("),
    ("a: {base: [0, 1], heading_deg: ¦-1.57}", "did you mean -90?"),
    ("a: {base: [0, 1], heading_deg: ¦540}", "more than a turn"),
    ("a: {joints_deg: [0, 0, 0, -126, 0, 115, ¦0.785]}", "did you mean 45?"),
)
REGIONS = (
    ("a: {centre: [0, 0, 0], size: [¦400, 300.5, 0.2]}", "did you mean 0.4 ("),
    ("a: {centre: [0, 0, 0], size: [¦12, 1, 0.2]}", "longer than 10 m"),
    ("a: {centre: [0, 0, 0], size: [¦-0.4, 1, 0.2]}", "not positive"),
    ("a: {centre: [0, 0, 0], size: [0.4, 1, ¦0]}", "not positive"),
    ("a: {centre: [¦3000, 0, 0], size: [1, 1, 0.2]}", "did you mean 3 ("),
    ("a: {centre: [0, 0, 0], size: [1, 1, 0.2], yaw_deg: ¦0.785}", "did you mean 45?"),
)
ROWS = [
    *(("item", text if text.startswith("- ") else f"- {text}", why) for text, why in ITEMS),
    *(("poses", text, why) for text, why in POSES),
    *(("regions", text, why) for text, why in REGIONS),
]


@pytest.mark.parametrize(("section", "mistake", "why"), ROWS, ids=[row[1] for row in ROWS])
def test_a_number_that_cannot_be_meant_is_refused_where_it_stands(tmp_path, section, mistake, why):
    text = file_with(**{section: mistake})
    found = found_in(tmp_path, text)
    at = found[0].location
    assert (at.line, at.column) == marked(text)
    assert why in str(found[0])
    assert found[0].hint
    # Edges of a region may be wrong together.
    assert len(found) == 1 or "300.5" in mistake


def test_the_task_around_the_mistakes_is_sound(tmp_path):
    assert found_in(tmp_path, file_with()) == []


def test_small_angles_may_be_meant(tmp_path):
    for angle in (0.3, 1.6, 2.5, 3.1, 90, 0, -1, 6.0):
        text = file_with(item=f"- drive: {{turn_deg: {angle}}}\n  name: at {angle}")
        assert not [one for one in found_in(tmp_path, text) if "radians" in one.message]
