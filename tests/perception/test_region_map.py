"""Maps of regions: objects, however low, and what was not seen."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio import SE3, exp3
from test_detector import CAMERA, FLOOR, ROBOT, WORKSPACE, box_world, looking_down

from hw import DepthFrame
from hw.sim import D435Noise, DepthRenderer, SimObject, World
from perception import RegionMap
from perception.registration import place_in_image
from robots import Box, Geom, Plane

SMALLEST = 1e-4
FRAMES = 3


def world(*halves: tuple[float, float, float], gap: float = 0.03) -> World:
    """Boxes of these half edges side by side in the container of `box_world`."""
    things, y = [], -0.1
    for half in halves:
        pose = SE3(np.eye(3), np.array([3.0, y + half[1], FLOOR + half[2]]))
        part = Geom(Box(half), SE3.Identity())
        things.append(SimObject(name=f"box {y}", parts=(part,), mass=0.1, pose=pose))
        y += 2.0 * half[1] + gap
    return World(box_world().fixtures, things)


def frames(of: World, oTc: SE3, seed: int = 0) -> list[DepthFrame]:
    depth, rng = DepthRenderer(CAMERA).render(of.shapes(), oTc), np.random.default_rng(seed)
    noisy = (D435Noise().apply(depth, ROBOT.camera, rng) for _ in range(FRAMES))
    return [DepthFrame(depth=one, intrinsics=CAMERA, oTc=oTc, stamp=0.0) for one in noisy]


def seen_in(shown: list[DepthFrame]) -> RegionMap:
    seen = RegionMap(WORKSPACE.oTr, WORKSPACE.size)
    for frame in shown:
        seen.add(frame)
    return seen


def test_an_empty_floor_is_empty_though_the_camera_is_mounted_a_little_wrong():
    oTc = looking_down(0.5, yaw=0.4)
    error = SE3(exp3(np.radians([0.3, -0.3, 0.3])), np.array([0.002, -0.002, 0.002]))
    told = [replace(one, oTc=oTc * error) for one in frames(world(), oTc)]
    seen = seen_in(told)
    assert seen.segments(SMALLEST) == []
    assert seen.hidden(SMALLEST) == []
    assert seen.seen > 0.98
    assert seen.lowest < 0.006
    higher = SE3(np.eye(3), np.array([0.0, 0.0, 0.004])) * oTc
    seen = seen_in([replace(one, oTc=higher) for one in told])
    assert seen.floor == pytest.approx(FLOOR + 0.004, abs=0.001)


def from_the_side(down_deg: float, distance: float) -> SE3:
    """A camera that looks along y at the middle of the floor."""
    down = np.radians(down_deg)
    turn = exp3(np.array([-np.pi / 2.0 - down, 0.0, 0.0]))
    away = distance * np.array([0.0, -np.cos(down), np.sin(down)])
    return SE3(turn, np.array([3.0, 0.0, FLOOR]) + away)


@pytest.mark.parametrize("down_deg", [25, 45])
def test_an_empty_floor_is_seen_from_a_flat_angle_and_what_gives_no_depth_is_not(down_deg):
    oTc = from_the_side(down_deg, 0.6)
    shown = frames(
        World([fixture for fixture in box_world().fixtures if fixture.name != "wall"], []), oTc
    )
    empty = seen_in(shown)
    assert empty.seen > 0.98
    assert empty.hidden(SMALLEST) == []
    v, u = np.indices(shown[0].depth.shape)
    rays = np.stack(
        [(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)], -1
    )
    rays = rays @ oTc.rotation.T
    points = oTc.translation + rays * ((FLOOR - oTc.translation[2]) / rays[..., 2])[..., None]
    round_one = np.hypot(points[..., 0] - 2.9, points[..., 1] - 0.05) < 0.0125
    seen = seen_in([replace(one, depth=np.where(round_one, np.nan, one.depth)) for one in shown])
    (part,) = seen.hidden(SMALLEST)
    np.testing.assert_allclose(part.centre, [2.9, 0.05, FLOOR], atol=0.01)


@pytest.mark.parametrize("half", [(0.03, 0.02, 0.001), (0.07, 0.003, 0.003)])
def test_what_is_thin_is_seen(half):
    (thing,) = seen_in(frames(world(half), looking_down(0.49))).segments(SMALLEST)
    assert thing.area == pytest.approx(4.0 * half[0] * half[1], rel=0.5)


def test_a_sheet_over_most_of_the_floor_is_not_taken_for_it():
    seen = seen_in(frames(world((0.15, 0.13, 0.004)), looking_down(0.49)))
    assert sum(one.area for one in seen.segments(SMALLEST)) > 0.06


OFF = [(0.0, 0.022, 0.0), (-0.022, 0.015, 0.0), (0.008, 0.006, 1.5)]
STANDING = tuple(one for one in box_world().fixtures if not isinstance(one.shape, Plane))


def seen_by_a_lost_robot(shown: list[DepthFrame], x=0.0, y=0.0, yaw_deg=0.0) -> RegionMap:
    """The map of the container of `box_world`, of a robot that is wrong about where it is."""
    off = SE3(exp3(np.radians([0.0, 0.0, yaw_deg])), np.array([x, y, 0.0]))
    oTm = WORKSPACE.oTr * off * WORKSPACE.oTr.inverse()
    base = SE3(np.eye(3), np.array([2.2, 0.0, 0.0]))
    region = oTm * WORKSPACE.oTr
    seen = RegionMap(region, WORKSPACE.size)
    for frame in shown:
        covariance = np.diag(np.square([0.02, 0.02, np.radians(1.0)]))
        place = place_in_image(
            frame,
            region,
            WORKSPACE.size,
            furniture=STANDING,
            oTb=oTm * base,
            mTb=base,
            covariance=covariance,
        )
        seen.add(frame, place)
    return seen


@pytest.mark.parametrize(("x", "y", "yaw_deg"), OFF)
def test_a_wall_that_is_off_the_map_is_no_object_and_what_leans_on_it_is_one(x, y, yaw_deg):
    for halves, number in (((), 0), (((0.02, 0.02, 0.02),), 1), (((0.01, 0.07, 0.01),), 1)):
        seen = seen_by_a_lost_robot(frames(world(*halves), looking_down(0.49)), x, y, yaw_deg)
        assert (len(seen.segments(SMALLEST)), len(seen.pieces)) == (number, number)


def test_a_container_that_was_moved_on_its_stand_is_found_where_it_is():
    """It is known to 2 cm; the edge of the stand, in sight too, is where the map has it."""

    def by(x: float) -> SE3:
        return SE3(np.eye(3), np.array([x, 0.05, 0.0]))

    def moved(x: float) -> list[Geom]:
        every = box_world().fixtures
        return [one.moved(by(x)) if one.piece == "wall" else one for one in every]

    base = SE3(np.eye(3), np.array([2.2, 0.0, 0.0]))
    for frame in frames(World(moved(0.07), []), by(-0.12) * looking_down(0.36)):
        place = place_in_image(
            frame,
            by(0.05) * WORKSPACE.oTr,
            WORKSPACE.size,
            furniture=moved(0.05),
            oTb=base,
            mTb=base,
            covariance=np.diag(np.square([0.06, 0.06, np.radians(2.5)])),
            moved="wall",
        )
        there = (by(0.07) * WORKSPACE.oTr).translation
        np.testing.assert_allclose(place.oTr.translation, there, atol=0.005)


def along_the_wall(count: int, length: float, width: float, height: float) -> World:
    """Boxes in a row, 2 mm from the wall of the container."""
    half = (length / 2.0, width / 2.0, height / 2.0)
    things = []
    for k in range(count):
        x = 3.0 + (k - (count - 1) / 2.0) * 0.04
        pose = SE3(np.eye(3), np.array([x, 0.178 - half[1], FLOOR + half[2]]))
        part = Geom(Box(half), SE3.Identity())
        things.append(SimObject(name=f"box {k}", parts=(part,), mass=0.1, pose=pose))
    return World(box_world().fixtures, things)


@pytest.mark.parametrize(
    ("count", "length", "width", "height"),
    [
        pytest.param(8, 0.025, 0.025, 0.025, id="a row of cubes"),
        pytest.param(1, 0.3, 0.024, 0.024, id="a bar"),
        pytest.param(1, 0.14, 0.014, 0.014, id="a pen"),
        pytest.param(1, 0.3, 0.024, 0.05, id="as high as the wall"),
    ],
)
def test_what_stands_along_a_wall_is_no_wall(count, length, width, height):
    shown = frames(along_the_wall(count, length, width, height), looking_down(0.49))
    seen = seen_by_a_lost_robot(shown, *OFF[1])
    assert len(seen.segments(SMALLEST)) == count


@pytest.mark.parametrize("thick", [0.008, 0.014])
def test_a_mat_on_all_of_the_floor_is_not_the_floor(thick):
    mat = world((0.2125, 0.1725, thick / 2.0))
    mat.objects[0].pose.translation[:2] = 3.0, 0.0
    seen = seen_by_a_lost_robot(frames(mat, looking_down(0.49)), *OFF[0])
    assert sum(one.area for one in seen.segments(SMALLEST)) > 0.1
    assert seen.cover < thick


def test_without_furniture_around_it_a_thin_cover_may_be_the_floor():
    seen = seen_in(frames(world(), looking_down(0.49)))
    assert 0.02 < seen.cover < 0.024


def test_pixels_that_are_far_apart_do_not_show_what_is_between():
    """Ten millimetres apart; cells have three."""
    (one, *_) = frames(world(), looking_down(0.49))
    depth = np.full_like(one.depth, np.nan)
    depth[::8, ::8] = one.depth[::8, ::8]
    assert 0.0 < seen_in([replace(one, depth=depth)]).seen < 0.2
