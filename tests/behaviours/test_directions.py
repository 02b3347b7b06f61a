"""Directions of approach: those that are chosen on the map, and what a tilted hand does."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from harness import looking_down
from pinocchio import SE3
from pinocchio.utils import rotate

from behaviours import Region, ToolPose, region_direction, tilted_if_needed
from behaviours.core.directions import Direction, tilt_of, upright, way_out
from behaviours.core.held_object import SetDownObjects
from behaviours.core.reachable_directions import sideways
from behaviours.views.viewpoint import hidden_by, out_of_view
from controller import Array, Surroundings
from hw.sim import load_fixtures
from perception import disc
from robots import Box, Geom, half_extents, load_robot

FRANKIE = load_robot("frankie")
COUNTER = load_fixtures("counter")


def region(x: float, floor: float, depth: float) -> Region:
    centre = np.array([x, 0.0, floor + 0.1])
    return Region(name="there", mTr=SE3(np.eye(3), centre), size=np.array([depth, 0.5, 0.2]))


def test_the_hand_tilts_towards_the_wall_only_where_furniture_asks_for_it() -> None:
    low = region_direction(FRANKIE, COUNTER, region(2.61, 0.4, 0.42))
    assert low.is_straight
    high = region_direction(FRANKIE, COUNTER, region(2.61, 0.9, 0.42))
    assert np.radians(15.0) <= high.tilt <= np.radians(60.0)
    assert high.heading == pytest.approx(0.0)
    level = region_direction(FRANKIE, COUNTER, region(2.61, 0.9, 0.42), "level")
    assert level.tilt >= np.radians(75.0)
    assert region_direction(FRANKIE, COUNTER, region(2.61, 1.9, 0.42)) is None


@pytest.mark.parametrize(("x", "turns"), [(2.5, [-90, 90, -75, 75]), (2.79, [-75, 75])])
def test_the_hand_comes_from_the_side_only_as_far_as_it_gets_to_the_object(x, turns):
    ahead, point = Direction(np.radians(30.0), 0.0), np.array([x, 0.0, 0.95])
    pieces = list(sideways(FRANKIE, COUNTER, ahead, point))
    assert [round(np.degrees(way.heading)) for way in pieces if way is not None] == turns
    assert pieces.count(None) > 100  # of work, each short


def test_a_way_point_is_tilted_about_the_finger_tips_if_it_is_no_place_to_be_met() -> None:
    pose = ToolPose(name="over", mTe=looking_down(2.6, 0.0, 1.15))
    tilted = tilted_if_needed(FRANKIE, COUNTER, pose, 0.15)
    assert tilt_of(tilted.mTe.rotation) > np.radians(10.0)
    assert tilted.mTe.rotation[0, 2] > 0.0  # it points away from the robot
    assert tilted.mTe.rotation[2, 0] > 0.0  # with the camera above
    assert tilted.mTe.translation == pytest.approx(pose.mTe.translation)
    assert tilted_if_needed(FRANKIE, COUNTER, pose, 0.01) is pose


def hand(tilt_deg: float, heading: float = 0.0) -> SE3:
    oRe = Direction(np.radians(tilt_deg), heading).rotation @ np.diag([1.0, -1.0, -1.0])
    return SE3(oRe, np.array([0.5, 0.2, 0.95]))


@pytest.mark.parametrize("tilt_deg", [0.0, 30.0, 60.0, 90.0])
def test_a_hand_goes_back_the_way_it_came_and_upwards(tilt_deg: float) -> None:
    oRe = hand(tilt_deg).rotation
    out = way_out(oRe)
    assert np.linalg.norm(out) == pytest.approx(1.0)
    assert out[2] > 0.15
    assert out @ -oRe[:, 2] > 0.95


def test_what_was_gripped_tilted_stands_upright_again_wherever_the_hand_points() -> None:
    grasp = hand(50.0, heading=0.3) * SE3(rotate("z", 0.2), np.zeros(3))
    way_in = Direction(np.radians(30.0), 2.0)
    oRe = upright(grasp, np.eye(3), way_in)
    turn = oRe @ grasp.rotation.T  # of the object, from where it stood
    assert turn[:, 2] == pytest.approx([0.0, 0.0, 1.0])
    assert np.arctan2(oRe[1, 2], oRe[0, 2]) == pytest.approx(2.0)


def test_what_a_tilted_hand_has_set_down_is_upright_and_on_the_surface() -> None:
    objects, mTe = SetDownObjects(), hand(60.0)
    outline = np.array([[x, y, 0.0] for x in (-0.03, 0.03) for y in (-0.02, 0.02)])
    objects.add(0.04, 0.05, mTe, outline)
    (box,) = objects.extents
    assert abs(box.pose.rotation[2, 2]) == pytest.approx(1.0)
    assert box.pose.translation[2] - half_extents(box.shape)[2] == pytest.approx(0.95 - 0.05)


def test_a_tilted_hand_moves_where_what_it_holds_does_not_hide_the_place() -> None:
    above, held = hand(60.0), Geom(Box((0.04, 0.03, 0.05)), SE3.Identity())
    place = disc(above.translation - [0.0, 0.0, 0.08], 0.05, 30)
    aside = out_of_view(room_with(held), above, place)[0]
    assert sees(above, held, place) < 0.5
    assert sees(aside, held, place) == 1.0


def sees(oTe: SE3, held: Geom, points: Array) -> float:
    """Share of (N, 3) points that are in a wide image and not behind a box."""
    oTc = oTe * FRANKIE.camera.eTc
    rays = oTc.translation + np.linspace(0.0, 1.0, 200)[:, None, None] * (points - oTc.translation)
    in_box = (rays - oTe.act(held.pose.translation)) @ oTe.rotation @ held.pose.rotation
    hidden = (np.abs(in_box) < half_extents(held.shape)).all(axis=2).any(axis=0)
    ahead = (points - oTc.translation) @ oTc.rotation
    inside = np.abs(ahead[:, :2] / ahead[:, 2:]).max(axis=1) < 0.9
    return float((inside & ~hidden).mean())


def room_with(held: Geom, *around: Geom) -> Any:
    """Something is held above a map with some fixtures."""
    return SimpleNamespace(
        robot=SimpleNamespace(description=FRANKIE),
        memory=SimpleNamespace(held=(held,)),
        localisation=SimpleNamespace(oTm=None),
        surroundings=Surroundings(fixtures=around),
    )


def test_a_hand_that_points_down_looks_from_where_no_wall_is() -> None:
    above, held = hand(0.0), Geom(Box((0.03, 0.03, 0.08)), SE3.Identity())
    place = disc(above.translation - [0.0, 0.0, 0.2], 0.04, 30)
    usual = above * SE3(np.eye(3), np.array([-0.18, 0.0, 0.0]))
    assert hidden_by(room_with(held), usual, place).total() <= 3
    assert out_of_view(room_with(held), above, place)[0].isApprox(usual)
    there = place.mean(axis=0) + above.rotation @ [-0.06, 0.0, -0.06]
    walled = room_with(held, Geom(Box((0.01, 0.06, 0.06)), SE3(above.rotation, there), "slot/wall"))
    assert hidden_by(walled, usual, place).most_common(1)[0][0] == "slot/wall is before it"
    assert hidden_by(walled, usual, place).total() > 15
    aside = out_of_view(walled, above, place)
    assert hidden_by(walled, aside[0], place).total() <= 3
    assert not np.allclose(aside[0].translation, aside[1].translation)
