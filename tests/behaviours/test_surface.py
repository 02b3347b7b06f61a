"""Place looks before it lets go: what a frame shows of a place, and what comes of it."""

from dataclasses import replace

import numpy as np
import pytest
from ended import failure, success
from harness import (
    FAR,
    TABLE_TOP,
    Harness,
    block,
    held_block,
    looking_down,
    place,
    table_world,
    with_the_hand_at,
)
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Region
from behaviours.places import slots
from behaviours.views.surface import Shows, floor_error, look_at
from hw import DepthFrame
from hw.sim import D435Noise, DepthRenderer, SimObject, World, load_localisation, made_wrong
from robots import Box, Geom, Plane, load_robot

RADIUS = 0.06
PLACES = slots(FAR, 0.13)


def look(world: World, x=0.7, y=0.0, floor=TABLE_TOP, camera=(0.635, 0.0, 0.8), hand=np.inf):
    """What the first frame shows of a place, the hand being at `camera`."""
    harness = with_the_hand_at(world, *camera)
    harness.tick(None)
    frame = harness.context.vision.new_frame()
    assert frame is not None
    return look_at(frame, np.array([x, y, floor]), RADIUS, hand)


def narrow_table() -> World:
    """A table that ends at x = 0.7 m."""
    top = SE3(np.eye(3), np.array([0.55, 0.0, TABLE_TOP / 2]))
    table = Geom(Box((0.15, 0.4, TABLE_TOP / 2)), top, "table")
    return World([Geom(Plane(), SE3.Identity(), "floor"), table], [])


@pytest.mark.parametrize(
    ("error", "shows"), [(0.0, Shows.SURFACE), (0.03, Shows.LOWER), (-0.03, Shows.HIGHER)]
)
def test_a_table_is_told_with_its_height(error, shows):
    seen = look(table_world(), floor=TABLE_TOP + error)
    assert seen.shows is shows
    assert seen.height == pytest.approx(-error, abs=0.003)


def test_an_object_at_the_place_is_higher_and_one_beside_it_is_not():
    half = (0.02, 0.03, 0.025)
    seen = look(table_world(block(half, x=0.70)))
    assert seen.shows is Shows.HIGHER
    assert seen.height == pytest.approx(0.05, abs=0.005)
    for x, y in ((0.82, 0.0), (0.70, 0.13), (0.70, -0.13)):
        assert look(table_world(block(half, x=x, y=y))).shows is Shows.SURFACE


def test_beyond_the_edge_there_is_no_surface():
    seen = look(narrow_table(), x=0.72)
    assert seen.shows is Shows.LOWER
    assert seen.height == pytest.approx(-TABLE_TOP, abs=0.02)
    assert look(narrow_table(), x=0.63).shows is Shows.SURFACE


@pytest.mark.parametrize("x", [0.72, 0.70, 0.66, 0.62])
def test_an_edge_is_seen_where_it_is(x):
    edge = look(narrow_table(), x=x).edge
    assert edge.distance == pytest.approx(0.70 - x, abs=0.012)
    np.testing.assert_allclose(edge.inwards, [-1.0, 0.0, 0.0], atol=0.1)


def test_no_edge_is_seen_far_from_one_or_among_objects():
    assert look(narrow_table(), x=0.58).edge is None
    assert look(table_world(block(x=0.75), block(x=0.70, y=0.08)), x=0.70).edge is None


@pytest.mark.parametrize("seed", range(4))
def test_what_is_wrong_with_the_camera_cancels_between_two_surfaces_that_it_sees(seed):
    """A wrong mount and scale show both too high or too low, but their difference as it is."""
    description = load_robot("frankie")
    truly, _, scale = made_wrong(description, load_localisation("poor"), seed)
    camera, rng = description.camera, np.random.default_rng(seed)
    renderer = DepthRenderer(camera.intrinsics)

    def frame(hand: SE3, *shapes: Geom) -> DepthFrame:
        depth = renderer.render(shapes, hand * truly.camera.eTc)
        depth = D435Noise().apply(depth, camera, rng) * np.float32(scale)
        oTc = hand * camera.eTc
        return DepthFrame(depth=depth, intrinsics=camera.intrinsics, oTc=oTc, stamp=0.0)

    tray = Geom(Box((0.3, 0.3, 0.2)), SE3(np.eye(3), np.array([0.0, 0.0, 0.2])), "tray")
    toy = Geom(Box((0.04, 0.03, 0.03)), SE3(np.eye(3), np.array([0.0, 0.0, 0.43])), "toy")
    table = Geom(Box((0.3, 0.3, 0.251)), SE3(np.eye(3), np.array([1.0, 0.0, 0.251])), "table")
    floor = Region(name="tray", mTr=SE3(np.eye(3), np.array([0.0, 0.0, 0.5])), size=np.full(3, 0.2))
    at_grasp = frame(looking_down(0.0, 0.0, 0.57), tray, toy)
    at_place = frame(looking_down(1.0, 0.0, 0.65, yaw=1.0), table)
    error = floor_error(at_grasp, np.array([0.0, 0.0, 0.43]), floor)
    seen = look_at(at_place, np.array([1.0, 0.0, 0.50]), RADIUS, np.inf)
    assert error is not None
    assert seen.height - error == pytest.approx(0.002, abs=0.002)  # the table is 2 mm higher


def test_a_place_out_of_the_picture_or_without_depth_is_unseen():
    assert look(table_world(), x=1.15).shows is Shows.UNSEEN
    harness = with_the_hand_at(table_world(), 0.635, 0.0, 0.8)
    harness.tick(None)
    frame = harness.context.vision.new_frame()
    dark = replace(frame, depth=np.full_like(frame.depth, np.nan))
    seen = look_at(dark, np.array([0.7, 0.0, TABLE_TOP]), RADIUS, np.inf)
    assert seen.shows is Shows.UNSEEN


def holding() -> Harness:
    """The hand holds a block over the table."""
    harness = held_block()
    harness.reach_over(looking_down(0.7, 0.0, TABLE_TOP + 0.3, yaw=np.pi / 2))
    return harness


def test_a_small_thing_below_what_is_held_is_seen_before_the_hand_goes_down():
    harness = held_block(block(half=(0.03, 0.06, 0.025)))
    harness.context.log.places_used["table"] = {2, 4, 6}
    x, y, z = PLACES[0]
    small: SimObject = block(half=(0.012, 0.012, 0.02), name="small")
    small.pose = SE3(np.eye(3), np.array([x, y, z + 0.02]))
    harness.world.objects.append(small)
    harness.reach_over(looking_down(x, y, z + 0.15, yaw=np.pi / 2))
    assert success(harness, place(harness)) == "placed on table, place 3"


@pytest.mark.parametrize("wrong_by", [0.01, -0.01])
def test_what_is_held_is_let_go_as_high_over_a_table_that_is_not_as_high_as_on_the_map(wrong_by):
    harness = holding()
    harness.context.log.floor_error = 0.0  # the camera saw the floor below the grasp as it is
    shift = SE3(np.eye(3), np.array([0.0, 0.0, wrong_by]))
    leaf = place(harness, Region(name="table", mTr=FAR.mTr * shift, size=FAR.size))
    thing, lower_end = harness.world.find("block"), np.inf
    harness.tick(leaf)
    while harness.world.held is thing:
        assert leaf.status is Status.RUNNING
        lower_end = -thing.reach(np.array([0.0, 0.0, -1.0])) - TABLE_TOP
        harness.tick(leaf)
    assert 0.002 < lower_end < 0.014  # by the map it would be 10 mm off


def test_without_a_frame_nothing_is_let_go():
    harness = holding()
    harness.robot.blind = True
    begun = harness.clock.now()
    assert failure(harness, place(harness)) == "no camera frame"
    assert harness.clock.now() - begun < 8.0
    assert harness.world.held is not None


def test_the_camera_looks_past_an_object_that_hides_the_place():
    harness = held_block(block(half=(0.035, 0.085, 0.025)))
    harness.context.log.places_used["table"] = {2, 4, 6}
    x, y, z = PLACES[0]
    harness.reach_over(looking_down(x, y, z + 0.15, yaw=np.pi / 2))
    leaf, told = place(harness), set()
    while harness.run(leaf, seconds=0.01) is Status.RUNNING:
        told.add(leaf.feedback_message)
    assert leaf.feedback_message == "placed on table, place 1"
    assert "looking at the place" in told
    where = harness.world.find("block").pose.translation
    np.testing.assert_allclose(where[:2], [x, y], atol=0.02)
