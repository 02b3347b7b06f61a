"""Kinematic world: held objects, falling objects, collisions of the hand."""

import numpy as np
import pytest
from pinocchio import SE3, exp3
from solid_world import FLOOR, box, cube

from hw.sim import Hand, World
from robots import load_robot

TURNED_DOWN = np.diag([1.0, -1.0, -1.0])
TABLE_TOP = 0.5
TABLE = box("table/top", (0.0, 0.0, 0.48), (0.3, 0.2, 0.02))
GRIPPER = load_robot("frankie").gripper


def hand(wTe: SE3) -> Hand:
    return Hand(GRIPPER, wTe)


def hand_at(x: float, y: float, z: float) -> SE3:
    return SE3(TURNED_DOWN, np.array([x, y, z]))


def picked(world: World, wTe: SE3) -> World:
    outcome = world.close_fingers(hand(wTe), 0.08, 20.0)
    assert outcome.holding is not None, outcome.reason
    return world


def test_a_held_object_moves_with_the_hand_and_stays_held():
    thing = cube("box", (0.0, 0.0, 0.02))
    world = picked(World([FLOOR], [thing]), hand_at(0.0, 0.0, 0.03))
    before = hand_at(0.0, 0.0, 0.03).actInv(thing.pose)
    after = SE3(exp3(np.array([0.3, 0.2, 1.0])) @ TURNED_DOWN, np.array([0.4, -0.2, 0.9]))
    world.carry(after)
    assert after.actInv(thing.pose).isApprox(before)
    assert world.resting_on(thing) == "hand"
    again = world.close_fingers(hand(after), 0.04, 20.0)
    assert again.holding == "box"
    assert again.width == pytest.approx(0.04, abs=2e-4)


@pytest.mark.parametrize(
    ("x", "top", "support"),
    [(0.0, TABLE_TOP, "table"), (0.31, TABLE_TOP, "table"), (0.6, 0.0, "floor")],
    ids=["table", "over the edge of the table", "floor"],
)
def test_a_released_object_falls_onto_what_is_below(x, top, support):
    thing = cube("box", (0.0, 0.0, TABLE_TOP + 0.02))
    world = picked(World([FLOOR, TABLE], [thing]), hand_at(0.0, 0.0, TABLE_TOP + 0.03))
    world.carry(hand_at(x, 0.0, 0.8))
    world.open_fingers()
    assert world.held is None
    assert thing.pose.translation == pytest.approx([x, 0.0, top + 0.02], abs=2e-4)
    assert world.resting_on(thing) == support


def test_an_object_released_against_the_board_above_it_falls_and_is_not_lifted_over_it():
    board = box("shelf", (0.0, 0.0, 0.84), (0.3, 0.2, 0.01))
    thing = cube("box", (0.0, 0.0, 0.812))
    world = World([FLOOR, TABLE, board], [thing])
    world.put("box", thing.pose)  # 2 mm inside the board
    assert thing.pose.translation[2] == pytest.approx(TABLE_TOP + 0.02, abs=2e-4)


def test_an_object_in_the_air_or_leaning_on_a_wall_has_no_support_there():
    thing = cube("box", (0.0, 0.0, 0.3))
    assert World([FLOOR], [thing]).resting_on(thing) == ""
    wall = box("wall", (0.0248, 0.0, 0.2), (0.005, 0.2, 0.2))
    thing = cube("box", (0.0, 0.0, 0.02))
    assert World([wall, FLOOR], [thing]).resting_on(thing) == "floor"


@pytest.mark.parametrize(
    ("wTe", "width", "hit"),
    [
        pytest.param(hand_at(0.0, 0.0, 0.02), 0.08, None, id="around"),
        pytest.param(hand_at(0.0, 0.0, 0.02), 0.034, "box", id="squeezed"),
        pytest.param(hand_at(0.0, 0.045, 0.02), 0.08, "box", id="finger inside"),
        pytest.param(hand_at(0.3, 0.0, 0.005), 0.08, "floor", id="floor"),
        pytest.param(hand_at(0.3, 0.0, 0.0065), 0.08, None, id="skims the floor"),
        pytest.param(hand_at(0.0, 0.5, 0.1), 0.08, "shelf", id="palm at shelf"),
    ],
)
def test_the_hand_collides_with_what_it_presses_into(wTe, width, hit):
    shelf = box("shelf", (0.0, 0.58, 0.18), (0.5, 0.01, 0.01))
    world = World([FLOOR, shelf], [cube("box", (0.0, 0.0, 0.02))])
    assert world.collision(hand(wTe), width) == hit


def test_what_is_held_collides_with_fixtures_but_not_with_objects():
    thing, other = cube("box", (0.0, 0.0, 0.02)), cube("other", (0.2, 0.0, 0.02))
    world = picked(World([FLOOR], [thing, other]), hand_at(0.0, 0.0, 0.03))
    assert world.collision(hand(hand_at(0.0, 0.0, 0.03)), 0.04) is None
    low = hand_at(0.1, 0.0, 0.022)
    world.carry(low)
    assert world.collision(hand(low), 0.04) == "floor"
    above = hand_at(0.2, 0.0, 0.06)
    world.carry(above)
    assert world.collision(hand(above), 0.04) is None
