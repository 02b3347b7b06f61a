"""Touching objects of one colour are split by their outlines and heights."""

import numpy as np
import pytest
from pinocchio import SE3

from behaviours import Region
from hw import DepthFrame
from hw.sim import (
    HOUSEHOLD,
    Container,
    D435Noise,
    DepthRenderer,
    Objects,
    Scene,
    Table,
    build_world,
    painted,
)
from perception import segment_objects
from robots import Box, Cylinder, Geom, Plane, load_robot

CAMERA = load_robot("frankie").camera
REGION = Region(
    name="tray", mTr=SE3(np.eye(3), np.array([0.0, 0.0, 0.1])), size=np.array([0.4, 0.3, 0.2])
)
RED = (214, 84, 70)


def box(x, y, length, width, height):
    pose = SE3(np.eye(3), np.array([x, y, height / 2.0]))
    return Geom(Box((length / 2.0, width / 2.0, height / 2.0)), pose, "thing", RED)


def can(x, y, radius, height):
    pose = SE3(np.eye(3), np.array([x, y, height / 2.0]))
    return Geom(Cylinder(radius, height / 2.0), pose, "thing", RED)


def count(*things, seed=0):
    """How many objects are seen in a noisy frame from straight above."""
    floor = Geom(Plane(), SE3.Identity(), "floor", (120, 150, 170))
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 0.42]))
    depth, ids = DepthRenderer(CAMERA.intrinsics).render_with_ids([floor, *things], wTc)
    colours = painted([floor, *things], ids)
    depth = D435Noise().apply(depth, CAMERA, np.random.default_rng(seed))
    frame = DepthFrame(
        depth=depth, intrinsics=CAMERA.intrinsics, wTc=wTc, stamp=0.0, paint=lambda: colours
    )
    return len(segment_objects(frame, REGION))


@pytest.mark.parametrize(
    "things",
    [
        pytest.param((box(0, 0, 0.12, 0.04, 0.03), box(0, 0.05, 0.03, 0.06, 0.05)), id="a T"),
        pytest.param((box(0, 0, 0.06, 0.06, 0.03), can(0.055, 0, 0.025, 0.06)), id="box and can"),
        pytest.param((can(0, 0, 0.025, 0.05), can(0.055, 0, 0.03, 0.08)), id="two cans"),
    ],
)
def test_two_things_that_touch_are_two(things):
    assert count(*things) == 2


@pytest.mark.parametrize("name", HOUSEHOLD)
def test_one_thing_of_many_parts_is_one(name):
    rng = np.random.default_rng(5)
    scene = Scene(
        container=Container(centre=(0.0, 0.0), floor_height=0.05),
        table=Table(centre=(0.0, 3.0)),
        objects=Objects(count=1, kinds=(name,), width_mm=(15.0, 60.0)),
    )
    (obj,) = build_world(scene, rng).objects
    here = SE3(obj.pose.rotation, obj.pose.translation * [0.0, 0.0, 1.0] - [0.0, 0.0, 0.05])
    assert count(*obj.placed(here)) == 1
