"""Segmentation of the objects in a region, their colours, and the consensus of frames."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from behaviours import Region
from hw import DepthFrame
from hw.sim import (
    Container,
    D435Noise,
    DepthRenderer,
    Objects,
    Scene,
    Table,
    build_world,
)
from hw.sim.camera.render import painted
from hw.sim.objects import HOUSEHOLD
from perception import colour_name, consensus, differ, segment_objects
from perception.objects.boundaries import Blob, candidate_boundaries
from robots import Box, Cylinder, Geom, Plane, Sphere, load_robot

FRANKIE = load_robot("frankie")
CAMERA = FRANKIE.camera.intrinsics
FLOOR = 0.4
REGION = Region(
    name="tray", mTr=SE3(np.eye(3), np.array([0.0, 0.0, 0.5])), size=np.array([0.4, 0.3, 0.2])
)
RED, BLUE = (214, 84, 70), (84, 104, 184)


def put(shape, x, y, height, colour, yaw=0.0):
    pose = SE3(pin.rpy.rpyToMatrix(0.0, 0.0, yaw), np.array([x, y, FLOOR + height / 2.0]))
    return Geom(shape, pose, "thing", colour)


def frame(*things, colour=True, height=0.45, noise=None):
    floor = Geom(Plane(), SE3(np.eye(3), np.array([0.0, 0.0, FLOOR])), "floor", (120, 150, 170))
    oTc = SE3(pin.rpy.rpyToMatrix(np.pi, 0.0, 0.0), np.array([0.0, 0.0, FLOOR + height]))
    depth, ids = DepthRenderer(CAMERA).render_with_ids([floor, *things], oTc)
    colours = painted([floor, *things], ids)
    if noise is not None:
        depth = D435Noise().apply(depth, FRANKIE.camera, np.random.default_rng(noise))
    return DepthFrame(
        depth=depth,
        intrinsics=CAMERA,
        oTc=oTc,
        stamp=0.0,
        paint=(lambda: colours) if colour else None,
    )


def look(*things):
    return segment_objects(frame(*things), REGION)


def test_place_size_width_and_colour_are_measured():
    box = put(Box((0.05, 0.02, 0.02)), 0.05, -0.03, 0.04, RED, yaw=0.5)
    (seen,) = look(box)
    assert np.linalg.norm(seen.position - [0.05, -0.03, FLOOR + 0.02]) < 0.003
    assert seen.size == pytest.approx((0.1, 0.04, 0.04), abs=0.004)
    assert seen.area == pytest.approx(0.004, rel=0.06)
    assert (seen.colour, seen.whole, seen.floor) == ("red", True, FLOOR)
    assert str(seen).startswith("the red object at 0.05, -0.03 on the map, 4")


def test_things_of_two_colours_that_touch_are_two():
    half = Box((0.02, 0.03, 0.02))
    things = put(half, -0.02, 0.0, 0.04, RED), put(half, 0.02, 0.0, 0.04, BLUE)
    assert sorted(one.colour for one in look(*things)) == ["blue", "red"]


def brick(x, y, length, width, height):
    return put(Box((length / 2.0, width / 2.0, height / 2.0)), x, y, height, RED)


def ball(x):
    return put(Sphere(0.025), x, 0.0, 0.05, RED)


def can(x, radius, height):
    return put(Cylinder(radius, height / 2.0), x, 0.0, height, RED)


@pytest.mark.parametrize(
    "things",
    [
        pytest.param((brick(0, 0, 0.12, 0.04, 0.03), brick(0, 0.05, 0.03, 0.06, 0.05)), id="a T"),
        pytest.param((brick(0, 0, 0.06, 0.06, 0.03), can(0.055, 0.025, 0.06)), id="box and can"),
        pytest.param((can(0, 0.025, 0.05), can(0.055, 0.03, 0.08)), id="two cans"),
        pytest.param((ball(0), ball(0.05)), id="a neck and a valley"),
        pytest.param((ball(0), can(0.05, 0.025, 0.09)), id="a step"),
    ],
)
def test_things_of_one_colour_that_touch_are_told_by_outlines_and_heights(things):
    assert len(segment_objects(frame(*things, noise=0), REGION)) == 2


@pytest.mark.parametrize("name", HOUSEHOLD)
def test_one_thing_of_many_parts_is_one(name):
    scene = Scene(
        container=Container(centre=(0.0, 0.0), floor_height=0.05),
        table=Table(centre=(0.0, 3.0)),
        objects=Objects(count=1, kinds=(name,), width_mm=(15.0, 60.0)),
    )
    (obj,) = build_world(scene, np.random.default_rng(5)).objects
    up = np.array([0.0, 0.0, FLOOR - 0.05])
    here = SE3(obj.pose.rotation, obj.pose.translation * [0.0, 0.0, 1.0] + up)
    assert len(segment_objects(frame(*obj.placed(here), noise=0), REGION)) == 1


def test_without_colours_heights_tell_things_apart():
    low = put(Box((0.03, 0.03, 0.01)), -0.03, 0.0, 0.02, RED)
    high = put(Box((0.03, 0.03, 0.04)), 0.03, 0.0, 0.08, BLUE)
    seen = segment_objects(frame(low, high, colour=False), REGION)
    assert [one.colour for one in seen] == ["", ""]


def test_what_stands_outside_or_is_cut_off_is_not_taken_for_whole():
    outside = put(Box((0.02, 0.02, 0.02)), 0.3, 0.0, 0.04, RED)
    cut_off = put(Box((0.05, 0.02, 0.02)), -0.17, 0.0, 0.04, BLUE)
    (seen,) = segment_objects(frame(outside, cut_off, height=0.2), REGION)
    assert seen.colour == "blue"
    assert not seen.whole


def test_no_depth_is_no_answer_and_an_empty_region_has_nothing():
    empty = frame()
    assert segment_objects(empty, REGION) == ()
    assert segment_objects(replace(empty, depth=np.full_like(empty.depth, np.nan)), REGION) is None


@pytest.mark.parametrize(
    ("colour", "name"),
    [
        ((220, 30, 30), "red"),
        ((240, 140, 20), "orange"),
        ((40, 160, 60), "green"),
        ((240, 150, 180), "pink"),
        ((120, 80, 50), "brown"),
        ((250, 250, 250), "white"),
        ((10, 10, 10), "black"),
    ],
)
def test_colours_have_the_names_that_people_give_them(colour, name):
    assert colour_name(*colour) == name


def test_no_light_makes_red_blue_but_it_may_make_it_orange():
    assert differ("red", "blue")
    assert differ("pink", "green")
    assert not any(differ("red", like) for like in ("orange", "purple", "pink", "brown", "black"))


LONG = put(Box((0.05, 0.02, 0.02)), 0.05, -0.03, 0.04, RED)
LEFT, RIGHT = (put(Box((0.021, 0.02, 0.02)), x, -0.03, 0.04, RED) for x in (0.021, 0.079))
OTHER = put(Box((0.02, 0.02, 0.02)), -0.08, 0.05, 0.04, BLUE)


def test_a_frame_that_cuts_a_thing_in_two_is_outvoted():
    whole, halves = look(LONG, OTHER), look(LEFT, RIGHT, OTHER)
    assert len(halves) == 3
    for looks in ((whole, halves, whole), (whole, whole, halves)):
        blue, red = consensus(looks)
        assert (blue.colour, red.colour) == ("blue", "red")
        assert red.size == pytest.approx((0.1, 0.04, 0.04), abs=0.004)


def test_what_one_frame_alone_shows_is_nothing_and_what_one_lacks_is_something():
    assert len(consensus((look(OTHER), look(LONG, OTHER), look(OTHER)))) == 1
    assert len(consensus((look(LONG, OTHER), look(OTHER), look(LONG, OTHER)))) == 2
    assert consensus((look(), look(), look(OTHER))) == ()


def test_a_ragged_outline_has_no_more_boundaries_than_a_tick_has_time_for():
    """As of a wall that noise cuts; they grow with the square of its corners."""
    comb = np.zeros((120, 300), dtype=np.bool_)
    comb[10:50, 10:290] = True
    for tooth in range(12, 280, 12):
        comb[50:90, tooth : tooth + 6] = True
    blob = Blob(above=np.where(comb, 0.05, 0.0).astype(np.float32), cells=comb, cell=0.0015)
    assert 0 < sum(1 for _ in candidate_boundaries(blob)) < 150
