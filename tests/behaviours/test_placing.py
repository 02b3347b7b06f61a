"""Thresholds of `place`: the room that it needs, edges, what is high, and where it stands then."""

import re

import numpy as np
import pytest
from harness import TABLE_TOP, looking_down
from pinocchio import SE3, exp3
from py_trees.common import Status
from scripted import FRANKIE, HERE, Script, up

from behaviours import Place, Region, ToolPose
from behaviours.views.surface import edge_near
from robots import Box, Geom

MIDDLE = HERE.translation[:2]


def slab(x: float, y: float, top: float, half: tuple[float, float], thick: float = 0.05) -> Geom:
    """A box of these half edges with its upper face at a height [m]."""
    pose = SE3(np.eye(3), np.array([x, y, top - thick / 2.0]))
    return Geom(Box((*half, thick / 2.0)), pose, "slab")


TABLE = slab(*MIDDLE, TABLE_TOP, (0.6, 0.6))
FLOOR = slab(*MIDDLE, 0.0, (3.0, 3.0))


def region(size: float = 0.2, floor: float = TABLE_TOP, length: float | None = None) -> Region:
    """With one place in the middle, unless it is longer."""
    pose = SE3(np.eye(3), np.array([*MIDDLE, floor + 0.05]))
    return Region(name="table", mTr=pose, size=np.array([length or size, size, 0.1]))


def placing(*seen: Geom, on: Region | None = None, **options) -> tuple[Script, Place]:
    """The hand holds something over the table, which the camera sees with what stands there."""
    script = Script(hand=up(0.3))
    script.seen = seen or (TABLE,)
    script.holds()
    where = {} if "at" in options or "onto" in options else {"on": on or region()}
    return script, Place("place", script.context, **where, **options)


def lowered(script: Script, leaf: Place) -> str:
    """What it says once it has let go, or has failed."""
    return script.follow(leaf, until=lambda: script.context.log.in_hand is None)


@pytest.mark.parametrize(("above", "comes_from"), [(0.49, 0.03), (0.51, 0.12)])
def test_the_hand_comes_in_low_where_something_is_within_half_a_metre_above(above, comes_from):
    board = slab(*MIDDLE, TABLE_TOP + above + 0.05, (0.2, 0.2))
    script = Script(board, hand=up(0.3))
    script.seen = (TABLE,)
    script.holds()
    leaf = Place("place", script.context, on=region())
    script.reads()
    leaf.tick_once()
    over = script.goal
    assert over.straight is (above > 0.5)  # else the base takes another stance first
    assert lowered(script, leaf) == "rising"
    low = over.target.translation[2] - comes_from
    np.testing.assert_allclose(script.context.oTe.translation, [*MIDDLE, low], atol=1e-9)


@pytest.mark.parametrize(
    ("pitch", "away", "is_free"),
    [(0.2, 0.048, False), (0.2, 0.065, True), (0.1, 0.048, True), (0.1, 0.03, False)],
)
def test_so_much_around_a_place_has_to_be_free(pitch, away, is_free):
    """6 cm, or with places near each other 45 % of their distance."""
    thing = slab(MIDDLE[0] + away + 0.02, MIDDLE[1], TABLE_TOP + 0.04, (0.02, 0.06))
    script, leaf = placing(TABLE, thing, on=region(pitch), pitch_m=pitch)
    said = lowered(script, leaf)
    assert said == ("rising" if is_free else "no place free on table, 1 taken or blocked (1)")


def edge_at(distance: float) -> Geom:
    """A table that ends so far from the place, ahead [m]."""
    return slab(MIDDLE[0] + distance - 0.6, MIDDLE[1], TABLE_TOP, (0.6, 0.6))


def test_a_place_at_an_edge_is_moved_off_it():
    """What is held reaches 8 cm; then there are 5 mm to the edge."""
    for distance in (0.1, 0.07, 0.015):
        script, leaf = placing(edge_at(distance), FLOOR)
        edge = edge_near(script.latest(0.0), np.array([*MIDDLE, TABLE_TOP]))
        ended = lowered(script, leaf)
        (shape,) = script.context.memory.set_down.shapes
        moved = MIDDLE[0] - shape.pose.translation[0]
        short = 0.0 if edge is None else 0.08 - edge.distance
        assert moved == pytest.approx(short + 0.005 if short > 0.0 else 0.0, abs=2e-3)
        assert len(script.context.log.messages) == (short > 0.0)
        assert ended == "rising"


@pytest.mark.parametrize(
    ("distance", "said"),
    [
        (-0.012, "place 1 of table is at an edge: passed over"),  # by 45 % of the pitch at most
        (-0.045, "place 1 of table is at an edge: passed over"),
        (-0.07, "no surface at place 1 of table: it is 0.50 m lower"),
    ],
)
def test_a_place_beyond_an_edge_is_not_moved_far(distance, said):
    script, leaf = placing(edge_at(distance), FLOOR)
    ended = lowered(script, leaf)
    assert script.context.log.in_hand is not None
    assert script.context.log.places_blocked == {}  # it may be free the next time
    told = [text for _, text in script.context.log.messages]
    if distance < -0.06:
        assert (told, ended) == ([], said)
    else:
        assert (told, ended) == ([said], "no place free on table, 1 taken or blocked (1)")


def test_all_motions_off_an_edge_together_are_not_far():
    script, leaf = placing(edge_at(0.035), FLOOR)
    said = script.follow(leaf, until=lambda: bool(script.context.log.messages))
    script.seen = (edge_at(-0.02), FLOOR)
    lowered(script, leaf)
    assert [text for _, text in script.context.log.messages][1:] == [
        "place 1 of table is at an edge: passed over"
    ], said


def shoulder() -> float:
    foot: SE3 = FRANKIE.bTa * FRANKIE.arm.joints[0]
    return float(foot.translation[2])


@pytest.mark.parametrize("is_high", [False, True])
def test_near_places_above_the_shoulder_are_filled_first_and_the_base_backs_off(is_high):
    floor = shoulder() + (0.01 if is_high else -0.01)
    high = region(0.2, floor, length=0.6)
    script, leaf = placing(slab(*MIDDLE, floor, (0.6, 0.6)), on=high)
    script.reads(up(floor - 0.2))
    lowered(script, leaf)
    (shape,) = script.context.memory.set_down.shapes
    away = shape.pose.translation[0] - MIDDLE[0]
    assert away == pytest.approx(-0.2 if is_high else 0.2, abs=0.01)
    pose = SE3(np.eye(3), np.array([*script.context.oTe.translation[:2], floor + 0.02]))
    script.seen = (*script.seen, Geom(Box((0.035, 0.02, 0.02)), pose, "what was set down"))
    script.follow(leaf, until=lambda: leaf.feedback_message == "backing off")
    assert (leaf.feedback_message == "backing off") is is_high


FALLEN = [(0.024, True, True), (0.015, True, False), (0.015, False, True)]
OUTLINE = np.array([(-0.035, -0.02, 0), (-0.035, 0.02, 0), (0.035, 0.02, 0), (0.035, -0.02, 0)])
THERE = ToolPose(name="there", mTe=looking_down(*MIDDLE, TABLE_TOP))


def stood(script: Script, leaf: Place, height: float, off=0.0, turn_deg=0.0) -> tuple[bool, str]:
    """Whether a block that stands so far from there, and turned, was placed; and what is said."""
    lowered(script, leaf)
    top = float(script.seen[-1].pose.translation[2]) + script.seen[-1].shape.half[2]
    turned = exp3(np.array([0.0, 0.0, np.radians(turn_deg)]))
    pose = SE3(turned, np.array([MIDDLE[0] + off, MIDDLE[1], top + height / 2.0]))
    script.seen = (*script.seen, Geom(Box((0.035, 0.02, height / 2.0)), pose, "block"))
    said = script.follow(leaf)
    assert (leaf.status is Status.SUCCESS) is (script.context.log.placed == 1)
    return leaf.status is Status.SUCCESS, said


@pytest.mark.parametrize(
    ("off", "turn_deg", "stands"),
    [(0.016, 0.0, True), (0.025, 0.0, False), (0.0, 8.0, True), (0.0, 13.0, False)],
)
def test_exactly_there_is_within_2_cm_and_10_degrees(off, turn_deg, stands):
    script, leaf = placing(at=THERE)
    beside = SE3(HERE.rotation, HERE.translation + np.array([0.12, 0.0, 0.0]))
    script.context.memory.set_down.add(0.04, 0.03, beside)  # it does not give way
    is_placed, said = stood(script, leaf, 0.04, off, turn_deg)
    np.testing.assert_allclose(
        script.context.memory.set_down.shapes[1].pose.translation[:2], MIDDLE, atol=1e-6
    )
    assert re.fullmatch(r"it stands \d+ mm and \d+° from there", said)
    assert is_placed is stands


@pytest.mark.parametrize(("height", "seen_whole", "stands"), FALLEN)
def test_what_is_stacked_has_fallen_off_if_it_reaches_less_high(height, seen_whole, stands):
    """By 1 cm than it did below the grasp, where all of it was seen then."""
    base = slab(*MIDDLE, TABLE_TOP + 0.05, (0.045, 0.045))
    script, leaf = placing(TABLE, base, onto=region(0.4))
    if seen_whole:
        script.context.log.grip_outline = OUTLINE
    is_placed, said = stood(script, leaf, height)
    assert is_placed is stands, said


def test_the_middle_of_what_is_held_comes_to_stand_there():
    script, leaf = placing(at=THERE)
    script.context.log.grip_outline = OUTLINE + np.array([0.02, 0.0, 0.0])
    lowered(script, leaf)
    np.testing.assert_allclose(script.context.oTe.translation[:2], MIDDLE - [0.02, 0.0], atol=1e-6)


def test_what_was_not_grasped_is_not_placed():
    script, leaf = placing()
    script.context.log.carried.clear()
    assert script.follow(leaf) == "nothing to place: nothing was grasped"
    script.reads(width=0.0)
    script.rest()
    assert script.follow(leaf) == "nothing to place: the fingers closed on nothing"
