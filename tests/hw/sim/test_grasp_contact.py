"""Contacts of closing fingers: a case for every outcome."""

from collections.abc import Sequence

import numpy as np
import pytest
from pinocchio import SE3, exp3
from solid_world import FLOOR, box

from hw.sim import GraspOutcome, Hand, Reason, SimObject, World
from hw.sim.contact import separation
from robots import Box, Capsule, Cylinder, Geom, Shape, Sphere, load_robot

TURNED_DOWN = np.diag([1.0, -1.0, -1.0])
UPRIGHT = np.eye(3)
LYING_ALONG_X = exp3(np.array([0.0, np.pi / 2.0, 0.0]))
LYING_ALONG_Y = exp3(np.array([np.pi / 2.0, 0.0, 0.0]))
GRIPPER = load_robot("frankie").gripper


def hand_at(height: float, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> SE3:
    """The hand pointing down, closing along y unless turned."""
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
    parts, pose = (Geom(shape, SE3.Identity(), name),), SE3(rotation, np.array([x, y, height]))
    return SimObject(name=name, parts=parts, mass=mass, pose=pose)


def close(
    wTe: SE3, objects: Sequence[SimObject], fixtures: Sequence[Geom] = (), opening: float = 0.08
) -> tuple[GraspOutcome, World]:
    world = World([FLOOR, *fixtures], objects)
    return world.close_fingers(Hand(GRIPPER, wTe), opening, 20.0), world


@pytest.mark.parametrize(
    ("shape", "rotation", "height", "width"),
    [
        (Box((0.03, 0.0375, 0.025)), UPRIGHT, 0.025, 0.075),
        (Sphere(0.025), UPRIGHT, 0.025, 0.05),
        (Cylinder(0.02, 0.05), LYING_ALONG_X, 0.02, 0.04),
        (Cylinder(0.02, 0.03), LYING_ALONG_Y, 0.02, 0.06),
        (Capsule(0.015, 0.04), LYING_ALONG_X, 0.015, 0.03),
    ],
)
def test_what_fits_between_the_fingers_is_held_at_its_width(shape, rotation, height, width):
    wTe = hand_at(height)
    outcome, world = close(wTe, [thing(shape, height, rotation=rotation)])
    assert outcome.reason is Reason.HELD
    assert outcome.holding == "thing"
    assert outcome.width == pytest.approx(width, abs=2e-4)
    pads = [s for s in Hand(GRIPPER, wTe).shapes(outcome.width) if "pad" in s.name]
    for pad in pads:
        assert separation(pad, world.objects[0].placed()[0])[0] == pytest.approx(0.0, abs=2e-4)


def test_a_skew_box_is_turned_and_a_tilted_hand_holds_too():
    skew = thing(Box((0.035, 0.02, 0.025)), 0.025, rotation=exp3(np.array([0.0, 0.0, 0.7])))
    outcome, _ = close(hand_at(0.025), [skew])
    assert outcome.reason is Reason.HELD
    assert abs(np.arctan2(skew.pose.rotation[1, 0], skew.pose.rotation[0, 0])) < 0.5
    assert outcome.width < 0.06
    tilt = exp3(np.array([0.15, 0.1, 0.9]))
    wTe = SE3(tilt @ TURNED_DOWN, np.array([0.0, 0.0, 0.3]))
    outcome, _ = close(wTe, [thing(Box((0.03, 0.02, 0.03)), 0.3, rotation=tilt)])
    assert outcome.reason is Reason.HELD
    assert outcome.width == pytest.approx(0.04, abs=2e-4)


def test_a_compound_is_held_by_the_part_between_the_pads():
    mug = thing(Cylinder(0.045, 0.04), 0.04)
    handle = Geom(Box((0.015, 0.008, 0.02)), SE3(UPRIGHT, np.array([0.058, 0.0, 0.0])))
    mug.parts = (*mug.parts, handle)
    outcome, _ = close(hand_at(0.04, x=0.065), [mug], opening=0.05)
    assert outcome.reason is Reason.HELD
    assert outcome.width == pytest.approx(0.016, abs=2e-4)


BOX = Box((0.03, 0.02, 0.025))


def tilted(angle: float, height: float) -> SE3:
    return SE3(exp3(np.array([angle, 0.0, 0.0])) @ TURNED_DOWN, np.array([0.0, 0.0, height]))


def block(mass: float = 0.1) -> list[SimObject]:
    return [thing(BOX, 0.025, mass=mass)]


def ball() -> list[SimObject]:
    return [thing(Sphere(0.03), 0.03)]


LOW = hand_at(0.025)
PAIR = [thing(Box((0.02, 0.01, 0.025)), 0.025, y=s * 0.022, name=f"box {s}") for s in (-1, 1)]
BESIDE = thing(Box((0.02, 0.005, 0.025)), 0.025, y=0.055, name="beside")
BAR = thing(Box((0.15, 0.01, 0.01)), 0.01, x=0.14, mass=0.6)
CASES = {
    "nothing": (hand_at(0.1), [], Reason.NOTHING, 0.0),
    "an object beside the pads": (hand_at(0.025, x=0.05), block(), Reason.NOTHING, 0.0),
    "an object outside": (hand_at(0.025, y=0.1), block(), Reason.NOTHING, 0.0),
    "two objects": (LOW, PAIR, Reason.TWO_OBJECTS, None),
    "another object, too far": (LOW, [*block(), BESIDE], Reason.HELD, 0.04),
    "too wide": (LOW, [thing(Box((0.03, 0.05, 0.025)), 0.025)], Reason.TOO_WIDE, 0.08),
    "a ball above its middle": (hand_at(0.058), ball(), Reason.NOT_ANTIPODAL, None),
    "a ball lower": (hand_at(0.035), ball(), Reason.HELD, None),
    "by the very tips": (hand_at(0.0575), block(), Reason.HELD, 0.04),
    "tips that skim the floor": (tilted(0.02, 0.0085), block(), Reason.HELD, None),
    "a heavy bar at its end": (hand_at(0.01), [BAR], Reason.TURNS, None),
    "as heavy as friction carries": (LOW, block(1.5), Reason.HELD, None),
    "heavier": (LOW, block(1.75), Reason.TOO_HEAVY, None),
}


@pytest.mark.parametrize("case", CASES)
def test_the_outcome_of_closing(case):
    wTe, objects, reason, width = CASES[case]
    outcome, world = close(wTe, objects)
    assert outcome.reason is reason
    assert outcome.holding == (objects[0].name if reason is Reason.HELD else None)
    assert (world.held is None) == (reason is not Reason.HELD)
    if width is not None:
        assert outcome.width == pytest.approx(width, abs=2e-4)


def test_a_single_pad_drags_an_object_only_so_far():
    near, far = (thing(Box((0.02, 0.0075, 0.025)), 0.025, y=y) for y in (0.018, 0.03))
    assert close(LOW, [near])[0].reason is Reason.HELD
    assert near.pose.translation == pytest.approx([0.0, 0.0, 0.025], abs=2e-4)
    assert close(LOW, [far])[0].reason is Reason.ONE_PAD
    assert far.pose.translation[1] == 0.03


@pytest.mark.parametrize("movable", [False, True], ids=["wall", "object"])
def test_an_object_cannot_be_dragged_through_another(movable):
    dragged = thing(Box((0.03, 0.01, 0.025)), 0.025, y=0.02)
    other = thing(Box((0.005, 0.01, 0.05)), 0.05, x=0.024, name="other")
    if movable:
        outcome, _ = close(LOW, [dragged, other])
    else:
        outcome, _ = close(LOW, [dragged], other.placed())
    assert outcome.reason is Reason.BLOCKED
    assert outcome.width == pytest.approx(0.06, abs=2e-4)
    assert dragged.pose.translation[1] == 0.02


def test_a_wall_that_stops_one_finger_stops_the_other():
    near = box("wall", (0.0, 0.01, 0.0), (0.2, 0.003, 0.05))
    far = box("wall", (0.0, 0.03, 0.0), (0.2, 0.005, 0.05))
    between = thing(Box((0.03, 0.015, 0.025)), 0.025)
    for objects, fixture, width in (([], near, 0.026), ([between], far, 0.07)):
        outcome, _ = close(hand_at(0.04), objects, [fixture])
        assert outcome.reason is Reason.BLOCKED
        assert outcome.width == pytest.approx(width, abs=2e-4)
