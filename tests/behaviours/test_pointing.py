"""The behaviours that point the camera: look_at, scan_for_objects, follow; and say."""

from dataclasses import replace
from math import degrees, inf

import numpy as np
import pytest
from ended import failure, success
from harness import REFLEX, TABLE_TOP, Harness, block, looking_down, table_world, with_the_hand_at
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Key, Region, ToolPose
from behaviours.conditions import Compare
from behaviours.detect import Detect
from behaviours.follow import Follow
from behaviours.look_at import LookAt
from behaviours.say import Say
from behaviours.scan_for_objects import ScanForObjects
from hw.sim.sim_object import Motion

LARGE = Region(
    name="table",
    mTr=SE3(np.eye(3), np.array([0.8, 0.0, TABLE_TOP + 0.1])),
    size=np.array([0.4, 0.7, 0.2]),
)
SMALL = replace(LARGE, name="small", size=np.array([0.34, 0.34, 0.2]))
BEHIND = ToolPose(name="bin", mTe=looking_down(-1.5, 0.5, 0.3))


def over_the_table(*objects) -> Harness:
    return with_the_hand_at(table_world(*objects), 0.6, 0.0, TABLE_TOP + 0.35)


@pytest.mark.parametrize(("at", "distance"), [(BEHIND, None), (LARGE, 0.6)])
def test_look_at_turns_the_camera_to_a_place(at, distance):
    harness = Harness(table_world())
    leaf = LookAt("look_at", harness.context, at=at, distance_m=distance)
    assert success(harness, leaf) == f"looking at {at.name}"
    harness.run_for(None, 0.5)
    frame = harness.robot.camera.latest(inf)
    point = (at.oTe if isinstance(at, ToolPose) else at.oTr).translation
    x, y, z = frame.oTc.actInv(point)
    assert degrees(np.arctan2(np.hypot(x, y), z)) < 3.0
    if distance is not None:
        assert z == pytest.approx(distance, abs=0.03)
        assert degrees(np.arcsin(-frame.oTc.rotation[2, 2])) > 72.0


def test_look_at_fails_without_a_camera_and_on_a_fault():
    harness = Harness(table_world())
    harness.robot.blind = True
    leaf = LookAt("look_at", harness.context, at=BEHIND)
    assert failure(harness, leaf) == "no camera frame"
    assert harness.speed == 0.0
    harness.robot.faults = (REFLEX,)
    assert failure(harness, leaf) == "the arm hit something"


def test_a_scan_counts_what_stands_in_a_region_larger_than_a_picture():
    spots = [(0.7, -0.28), (0.9, -0.1), (0.75, 0.1), (0.9, 0.3)]
    harness = over_the_table(*(block(x=x, y=y, name=f"b{x}{y}") for x, y in spots))
    count: Key[int] = Key("count")
    leaf = ScanForObjects("scan", harness.context, region=LARGE, count=count)
    assert success(harness, leaf) == "4 objects in table, on the 100 % seen"
    assert count.read() == 4
    things = sorted(leaf._survey.map.segments(1e-4), key=lambda thing: thing.centre[1])
    np.testing.assert_allclose([thing.centre[:2] for thing in things], spots, atol=0.01)
    assert [thing.area for thing in things] == pytest.approx([24e-4] * 4, rel=0.3)


@pytest.mark.parametrize("is_seen", [True, False])
def test_a_scan_looks_over_what_an_object_hides_and_counts_at_least_what_it_sees(
    is_seen, monkeypatch
):
    tall = block(x=0.84, half=(0.02, 0.04, 0.09), name="tall")
    behind = block(x=0.885, half=(0.01, 0.01, 0.01), name="behind")
    harness, count = over_the_table(tall, behind), Key[int]("count")
    yes, no, unknown = Status.SUCCESS, Status.FAILURE, Status.RUNNING
    if not is_seen:
        monkeypatch.setattr("behaviours.views.survey._BEHIND", 0)
    said = success(harness, ScanForObjects("scan", harness.context, region=SMALL, count=count))
    assert said.startswith("2 objects in small" if is_seen else "at least 1 object in small")
    there = Key[int]("there")
    assert is_seen or harness.run(Detect("see", harness.context, region=SMALL, count=there)) is yes
    assert is_seen or f"{there.read()}" == "at least 1"
    asked = [
        *(Compare("is", harness.context, value=count.read(), equals=n) for n in (0, 1, 2)),
        *(Compare("is", harness.context, value=count.read(), least=n) for n in (1, 2, 3)),
    ]
    for one in asked:
        one.tick_once()
    answers = (
        [no, no, yes, yes, yes, no] if is_seen else [no, unknown, unknown, yes] + 2 * [unknown]
    )
    assert [one.status for one in asked] == answers


def test_a_scan_does_not_count_by_what_it_cannot_see():
    harness = over_the_table()
    pose, count = SE3(np.eye(3), np.array([0.8, 0.0, TABLE_TOP - 0.2])), Key[int]("count")
    beyond = Region(name="shelf", mTr=pose, size=np.array([0.3, 0.3, 0.2]))
    options = {"region": beyond, "count": count, "height_m": 0.65}
    leaf = ScanForObjects("scan", harness.context, **options)
    assert failure(harness, leaf).startswith("100 % of shelf not seen")
    with pytest.raises(LookupError):
        count.read()


def test_a_scan_fails_on_a_fault_at_a_view():
    harness = over_the_table()
    leaf = ScanForObjects("scan", harness.context, region=LARGE, count=Key("count"))
    while not leaf.feedback_message.endswith("1 image"):
        harness.tick(leaf)
    harness.robot.faults = (REFLEX,)
    assert failure(harness, leaf) == "the arm hit something"


def test_a_scan_that_cannot_reach_a_view_says_which():
    harness = over_the_table()
    harness.robot.stuck = True
    leaf = ScanForObjects("scan", harness.context, region=LARGE, count=Key("count"))
    assert failure(harness, leaf).startswith("stuck on the way to view 1 of 4 of table: ")


def moving_block(y: float = -0.1, until: float = np.inf):
    thing, along = block(x=0.8, y=y), np.array([0.0, 0.2, 0.0])
    start = thing.pose.translation.copy()
    thing.motion = Motion(start=start, along=along, period=8.0, until=until)
    return thing


def test_follow_stays_over_a_moving_object_and_succeeds_when_it_stands_still():
    harness = over_the_table(moving_block(until=8.0))
    leaf = Follow("follow", harness.context, within=LARGE)
    harness.run_for(leaf, 2.0)
    behind = []
    while leaf.status is Status.RUNNING:
        harness.tick(leaf)
        away = harness.world.objects[0].pose.translation - harness.context.oTe.translation
        behind.append(np.hypot(*away[:2]))
    assert leaf.status is Status.SUCCESS
    assert leaf.feedback_message == "it has stood still for 2.0 s"
    assert max(behind) < 0.06
    assert harness.clock.now() > 8.0
    assert behind[-1] < 0.015


def test_follow_fails_when_there_is_nothing_to_follow_or_see():
    harness = over_the_table()
    leaf = Follow("follow", harness.context, within=LARGE)
    assert failure(harness, leaf) == "nothing to follow for 1.5 s"
    harness.robot.blind = True
    assert failure(harness, leaf) == "no camera frame for 1.5 s"


def test_follow_fails_when_the_hand_cannot_keep_up_and_on_a_fault():
    harness = over_the_table(block(x=0.9, y=0.25))
    harness.robot.stuck = True
    leaf = Follow("follow", harness.context, within=LARGE)
    assert failure(harness, leaf).startswith("cannot keep up, 0.")
    harness.robot.faults = (REFLEX,)
    assert failure(harness, leaf) == "the arm hit something"


def test_say_tells_people_once():
    harness = Harness(table_world())
    harness.run_for(None, 0.5)
    leaf = Say("say", harness.context, text="I see {value} things.", value=3)
    assert harness.run(leaf) is Status.SUCCESS
    [(stamp, text)] = harness.context.log.messages
    assert text == leaf.feedback_message == "I see 3 things."
    assert stamp.seconds == pytest.approx(0.5)
