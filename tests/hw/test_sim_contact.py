"""Closing the fingers on hand-made cases: one for every way that it can end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from pinocchio import SE3, exp3

from hw.sim import GraspOutcome, Hand, Reason, SimObject, World
from hw.sim.contact import separation
from hw.sim.objects import OBJECT_CLASSES, make_object
from robots import Box, Capsule, Cylinder, Geom, Plane, Shape, Sphere, load_robot

FLOOR = Geom(Plane(), SE3.Identity(), "floor")
TURNED_DOWN = np.diag([1.0, -1.0, -1.0])
UPRIGHT = np.eye(3)
LYING_ALONG_X = exp3(np.array([0.0, np.pi / 2.0, 0.0]))
LYING_ALONG_Y = exp3(np.array([np.pi / 2.0, 0.0, 0.0]))


GRIPPER = load_robot("frankie").gripper


def hand(wTe: SE3) -> Hand:
    return Hand(GRIPPER, wTe)


def hand_at(height: float, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> SE3:
    """The hand pointing down; its closing direction is the world's y when not turned."""
    return SE3(exp3(np.array([0.0, 0.0, yaw])) @ TURNED_DOWN, np.array([x, y, height]))


def thing(
    shape: Shape,
    height: float,
    x: float = 0.0,
    y: float = 0.0,
    rotation: np.ndarray = UPRIGHT,
    name: str = "thing",
    mass: float = 0.1,
) -> SimObject:
    return SimObject(
        name=name,
        parts=(Geom(shape, SE3.Identity(), name),),
        mass=mass,
        pose=SE3(rotation, np.array([x, y, height])),
    )


def close(
    wTe: SE3,
    objects: Sequence[SimObject],
    fixtures: Sequence[Geom] = (),
    opening: float = 0.08,
    force: float = 20.0,
) -> tuple[GraspOutcome, World]:
    world = World([FLOOR, *fixtures], objects)
    return world.close_fingers(hand(wTe), opening, force), world


@pytest.mark.parametrize(
    ("shape", "rotation", "height", "width"),
    [
        (Box((0.03, 0.02, 0.025)), UPRIGHT, 0.025, 0.04),
        (Box((0.03, 0.0075, 0.025)), UPRIGHT, 0.025, 0.015),
        (Box((0.03, 0.0375, 0.025)), UPRIGHT, 0.025, 0.075),
        (Sphere(0.025), UPRIGHT, 0.025, 0.05),
        (Cylinder(0.02, 0.04), UPRIGHT, 0.04, 0.04),
        (Cylinder(0.02, 0.05), LYING_ALONG_X, 0.02, 0.04),
        (Cylinder(0.02, 0.03), LYING_ALONG_Y, 0.02, 0.06),
        (Capsule(0.015, 0.04), LYING_ALONG_X, 0.015, 0.03),
    ],
    ids=[
        "box",
        "thin box",
        "wide box",
        "ball",
        "standing cylinder",
        "cylinder across",
        "cylinder by its ends",
        "capsule",
    ],
)
def test_what_fits_between_the_fingers_is_held_at_its_width(
    shape: Shape, rotation: np.ndarray, height: float, width: float
) -> None:
    wTe = hand_at(height)
    outcome, world = close(wTe, [thing(shape, height, rotation=rotation)])
    assert outcome.reason is Reason.HELD
    assert outcome.holding == "thing"
    assert outcome.width == pytest.approx(width, abs=2e-4)
    pads = [s for s in hand(wTe).shapes(outcome.width) if "pad" in s.name]
    for pad in pads:
        assert separation(pad, world.objects[0].placed()[0])[0] == pytest.approx(0.0, abs=2e-4)


@pytest.mark.parametrize("offset", [-0.018, -0.005, 0.012, 0.018])
def test_an_offset_box_is_dragged_to_the_middle(offset: float) -> None:
    box = thing(Box((0.03, 0.02, 0.025)), 0.025, y=offset)
    outcome, _ = close(hand_at(0.025), [box])
    assert outcome.reason is Reason.HELD
    assert box.pose.translation == pytest.approx([0.0, 0.0, 0.025], abs=2e-4)


def test_a_skew_box_is_turned_until_the_pads_can_hold_it() -> None:
    box = thing(Box((0.035, 0.02, 0.025)), 0.025, rotation=exp3(np.array([0.0, 0.0, 0.7])))
    outcome, _ = close(hand_at(0.025), [box])
    assert outcome.reason is Reason.HELD
    turned = np.arctan2(box.pose.rotation[1, 0], box.pose.rotation[0, 0])
    assert abs(turned) < 0.5
    assert outcome.width < 0.06


def test_the_hand_may_be_turned_and_tilted() -> None:
    tilt = exp3(np.array([0.15, 0.1, 0.9]))
    box = thing(Box((0.03, 0.02, 0.03)), 0.3, rotation=tilt)
    wTe = SE3(tilt @ TURNED_DOWN, np.array([0.0, 0.0, 0.3]))
    outcome, _ = close(wTe, [box])
    assert outcome.reason is Reason.HELD
    assert outcome.width == pytest.approx(0.04, abs=2e-4)


def test_a_compound_is_held_by_the_part_between_the_pads() -> None:
    mug = SimObject(
        name="mug",
        parts=(
            Geom(Cylinder(0.045, 0.04), SE3.Identity()),
            Geom(Box((0.015, 0.008, 0.02)), SE3(np.eye(3), np.array([0.058, 0.0, 0.0]))),
        ),
        mass=0.2,
        pose=SE3(np.eye(3), np.array([0.0, 0.0, 0.04])),
    )
    outcome, _ = close(hand_at(0.04, x=0.065), [mug], opening=0.05)
    assert outcome.reason is Reason.HELD
    assert outcome.width == pytest.approx(0.016, abs=2e-4)


def test_nothing_between_the_fingers_closes_them_fully() -> None:
    outcome, _ = close(hand_at(0.1), [])
    assert outcome == GraspOutcome(holding=None, width=0.0, reason=Reason.NOTHING)


def test_the_pads_miss_what_is_beside_them() -> None:
    outcome, _ = close(hand_at(0.025, x=0.05), [thing(Box((0.03, 0.02, 0.025)), 0.025)])
    assert outcome.reason is Reason.NOTHING


def test_the_pads_miss_what_is_outside_the_fingers() -> None:
    outcome, _ = close(hand_at(0.025, y=0.1), [thing(Box((0.03, 0.02, 0.025)), 0.025)])
    assert outcome.reason is Reason.NOTHING


def test_two_objects_are_not_held() -> None:
    pair = [thing(Box((0.02, 0.01, 0.025)), 0.025, y=s * 0.022, name=f"box {s}") for s in (-1, 1)]
    outcome, world = close(hand_at(0.025), pair)
    assert outcome.reason is Reason.TWO_OBJECTS
    assert world.held is None


def test_a_second_object_too_far_to_be_reached_does_not_matter() -> None:
    held = thing(Box((0.02, 0.02, 0.025)), 0.025, name="held")
    beside = thing(Box((0.02, 0.005, 0.025)), 0.025, y=0.055, name="beside")
    outcome, _ = close(hand_at(0.025), [held, beside])
    assert outcome.holding == "held"


def test_a_single_pad_does_not_drag_an_object_all_the_way() -> None:
    far = thing(Box((0.02, 0.0075, 0.025)), 0.025, y=0.03)
    outcome, _ = close(hand_at(0.025), [far])
    assert outcome.reason is Reason.ONE_PAD
    assert far.pose.translation[1] == 0.03


def test_what_is_wider_than_the_opening_is_not_held() -> None:
    outcome, _ = close(hand_at(0.025), [thing(Box((0.03, 0.05, 0.025)), 0.025)])
    assert outcome.reason is Reason.TOO_WIDE
    assert outcome.width == 0.08
    outcome, _ = close(hand_at(0.025), [thing(Box((0.03, 0.021, 0.025)), 0.025)], opening=0.04)
    assert outcome.reason is Reason.TOO_WIDE


def test_a_ball_slips_out_when_gripped_above_its_middle() -> None:
    outcome, world = close(hand_at(0.058), [thing(Sphere(0.03), 0.03)])
    assert outcome.reason is Reason.NOT_ANTIPODAL
    assert world.held is None
    assert outcome.width > 0.0


def test_a_low_grip_on_the_same_ball_holds() -> None:
    outcome, _ = close(hand_at(0.035), [thing(Sphere(0.03), 0.03)])
    assert outcome.reason is Reason.HELD


@pytest.mark.parametrize("movable", [False, True], ids=["wall", "object"])
def test_an_object_cannot_be_dragged_through_another(movable: bool) -> None:
    box = thing(Box((0.03, 0.01, 0.025)), 0.025, y=0.02)
    obstacle = Box((0.005, 0.01, 0.05))
    if movable:
        other = thing(obstacle, 0.05, x=0.024, name="other")
        outcome, _ = close(hand_at(0.025), [box, other])
    else:
        where = SE3(np.eye(3), np.array([0.024, 0.0, 0.05]))
        outcome, _ = close(hand_at(0.025), [box], [Geom(obstacle, where, "wall")])
    assert outcome.reason is Reason.BLOCKED
    assert outcome.width == pytest.approx(0.06, abs=2e-4)
    assert box.pose.translation[1] == 0.02


def test_the_fingers_jam_on_a_wall_between_them() -> None:
    wall = Geom(Box((0.2, 0.003, 0.05)), SE3(np.eye(3), np.array([0.0, 0.01, 0.0])), "wall")
    outcome, _ = close(hand_at(0.04), [], [wall])
    assert outcome.reason is Reason.BLOCKED
    assert outcome.width == pytest.approx(0.026, abs=2e-4)


def test_a_wall_that_stops_one_finger_stops_the_other() -> None:
    box = thing(Box((0.03, 0.015, 0.025)), 0.025)
    wall = Geom(Box((0.2, 0.005, 0.05)), SE3(np.eye(3), np.array([0.0, 0.03, 0.0])), "wall")
    outcome, _ = close(hand_at(0.04), [box], [wall])
    assert outcome.reason is Reason.BLOCKED
    assert outcome.width == pytest.approx(0.07, abs=2e-4)


def test_fingers_that_skim_the_floor_are_not_blocked_by_it() -> None:
    box = thing(Box((0.03, 0.02, 0.02)), 0.02)
    tilted = SE3(exp3(np.array([0.02, 0.0, 0.0])) @ TURNED_DOWN, np.array([0.0, 0.0, 0.0085]))
    outcome, _ = close(tilted, [box])
    assert outcome.reason is Reason.HELD


def test_the_very_tips_hold_a_box() -> None:
    tip_height = 0.05 - 0.0005
    outcome, _ = close(hand_at(tip_height + 0.008), [thing(Box((0.03, 0.02, 0.025)), 0.025)])
    assert outcome.reason is Reason.HELD


@pytest.mark.parametrize(("mass", "reason"), [(0.05, Reason.HELD), (0.6, Reason.TURNS)])
def test_a_long_bar_is_held_at_its_end_only_if_it_is_light(mass: float, reason: Reason) -> None:
    bar = thing(Box((0.15, 0.01, 0.01)), 0.01, x=0.14, mass=mass)
    outcome, world = close(hand_at(0.01), [bar])
    assert outcome.reason is reason
    assert (world.held is None) == (reason is Reason.TURNS)


def test_the_same_bar_is_held_at_its_middle() -> None:
    outcome, _ = close(hand_at(0.01), [thing(Box((0.15, 0.01, 0.01)), 0.01, mass=0.6)])
    assert outcome.reason is Reason.HELD


def test_the_rim_of_a_vessel_is_held_by_its_wall() -> None:
    bowl = make_object(
        "bowl", OBJECT_CLASSES["bowl"], (0.006, 0.006), (0.2, 0.2), np.random.default_rng(0)
    )
    rim = bowl.reach(np.array([1.0, 0.0, 0.0])) - 0.003
    top = bowl.reach(np.array([0.0, 0.0, 1.0]))
    outcome, _ = close(hand_at(top - 0.004, x=rim, yaw=np.pi / 2.0), [bowl], opening=0.06)
    assert outcome.reason is Reason.HELD
    assert outcome.width < 0.012


def test_a_ball_at_the_end_of_a_shaft_slides_until_the_pads_press_on_the_shaft() -> None:
    parts = (
        Geom(Cylinder(0.01, 0.04), SE3(LYING_ALONG_X, np.zeros(3))),
        Geom(Sphere(0.02), SE3(UPRIGHT, np.array([0.04, 0.0, 0.0]))),
    )
    dumbbell = SimObject(
        name="dumbbell", parts=parts, mass=0.1, pose=SE3(UPRIGHT, np.array([0.0, 0.0, 0.02]))
    )
    outcome, _ = close(hand_at(0.02, x=0.018), [dumbbell])
    assert outcome.reason is Reason.HELD
    assert outcome.width == pytest.approx(0.02, abs=4e-3)


@pytest.mark.parametrize(("mass", "reason"), [(1.5, Reason.HELD), (1.75, Reason.TOO_HEAVY)])
def test_friction_must_carry_the_weight(mass: float, reason: Reason) -> None:
    box = thing(Box((0.03, 0.02, 0.025)), 0.025, mass=mass)
    outcome, _ = close(hand_at(0.025), [box], force=20.0)
    assert outcome.reason is reason


def test_what_slips_off_stays_where_the_pads_dragged_it() -> None:
    box = thing(Box((0.03, 0.02, 0.025)), 0.025, y=0.01, mass=5.0)
    outcome, world = close(hand_at(0.025), [box])
    assert outcome.touched == "thing"
    assert world.held is None
    assert box.pose.translation == pytest.approx([0.0, 0.0, 0.025], abs=2e-4)


def test_what_slips_off_a_tilted_hand_is_back_on_the_floor() -> None:
    box = thing(Box((0.03, 0.01, 0.025)), 0.025, y=0.02, mass=5.0)
    tilted = SE3(exp3(np.array([0.25, 0.0, 0.0])) @ TURNED_DOWN, np.array([0.0, 0.0, 0.04]))
    outcome, world = close(tilted, [box])
    assert outcome.holding is None
    assert box.pose.translation[1] < 0.01
    assert box.pose.translation[2] == pytest.approx(0.025, abs=2e-4)
    assert world.resting_on(box) == "floor"
