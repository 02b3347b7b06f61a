"""The map of the floor: distances as exact geometry has them, and ways that are ways."""

from itertools import pairwise

import coal
import numpy as np
import pinocchio as pin
import pytest
from pinocchio import SE3

from controller.floor.floor_map import NEAR, FloorMap
from robots import Box, Capsule, Cylinder, Geom, Plane, Sphere, coal_geometry, load_robot

FRANKIE = load_robot("frankie")
LENGTH, WIDTH, HEIGHT = FRANKIE.base.size


def placed(shape, x: float, y: float, z: float, *, yaw=0.0, tilt=0.0) -> Geom:
    rotation = pin.utils.rotate("z", yaw) @ pin.utils.rotate("x", tilt)
    return Geom(shape, SE3(rotation, np.array([x, y, z])))


def box(x: float, y: float, dx: float, dy: float, *, height=0.3, yaw=0.0) -> Geom:
    return placed(Box((dx / 2, dy / 2, height / 2)), x, y, height / 2, yaw=yaw)


def distance(a: Geom, b: Geom) -> float:
    """Between two shapes, by Coal."""
    one, two = (
        (coal_geometry(g.shape), coal.Transform3s(g.pose.rotation, g.pose.translation))
        for g in (a, b)
    )
    return coal.distance(*one, *two, coal.DistanceRequest(), coal.DistanceResult())


def base_at(x: float, y: float, heading: float) -> Geom:
    half = (LENGTH / 2, WIDTH / 2, HEIGHT / 2)
    return placed(Box(half), x, y, HEIGHT / 2, yaw=heading)


def some_shapes(rng: np.random.Generator, count: int, size: float) -> tuple[Geom, ...]:
    """Low things of every kind, as high as the base and leaning."""
    shapes = (Box((0.3, 0.2, 0.15)), Cylinder(0.2, 0.15), Capsule(0.1, 0.2), Sphere(0.18))
    things = []
    for k in range(count):
        (x, y), yaw = rng.uniform(0.0, size, 2), rng.uniform(0.0, 6.0)
        things.append(placed(shapes[k % 4], x, y, 0.18, yaw=yaw, tilt=np.pi / 2 * (k % 4 == 2)))
    return tuple(things)


def test_the_room_around_a_base_is_what_coal_measures():
    rng = np.random.default_rng(3)
    fixtures = some_shapes(rng, 12, 5.0)
    bases = np.column_stack([rng.uniform(0.0, 5.0, (300, 2)), rng.uniform(-np.pi, np.pi, 300)])
    found = FloorMap(fixtures, FRANKIE).stands_free(bases)
    exact = np.array([min(distance(base_at(*b), f) for f in fixtures) for b in bases])
    near = exact < NEAR
    apart = near & (exact > 0.0)
    assert apart.sum() > 50
    # Where a corner of a thing comes between two points of the base's edge, it is a little off.
    np.testing.assert_allclose(found[apart], exact[apart], atol=0.02)
    assert (found[near & (exact < -0.02)] < 0.0).all()
    assert (found[~near] > NEAR - 0.02).all()


def test_what_hangs_above_the_base_is_in_the_way_of_the_arm_only():
    top = placed(Box((0.6, 0.3, 0.015)), 0.0, 1.0, 0.485)  # its underside is 47 cm high
    room = FloorMap((top,), FRANKIE)
    edge = 0.7  # y of the edge of the table
    toe_under = [0.0, edge - 0.30, np.pi / 2]  # the base reaches 5 cm under it, the arm does not
    arm_under = [0.0, edge - 0.15, np.pi / 2]
    clear, blocked = room.stands_free(np.array([toe_under, arm_under]))
    assert clear == pytest.approx(0.30 - 0.15 - 0.06, abs=0.01)
    assert blocked < 0.0


@pytest.mark.parametrize("shape", [Box((0.1, 0.1, 0.1)), Cylinder(0.1, 0.1), Sphere(0.1)])
def test_what_is_over_the_head_of_the_robot_is_not_on_the_map(shape):
    assert FloorMap((placed(shape, 1.0, 0.0, 2.0), Geom(Plane(), SE3.Identity())), FRANKIE).free


def test_the_way_leads_around_and_its_cost_is_about_its_length():
    wall = box(0.0, 0.0, 0.2, 4.0)
    room = FloorMap((wall,), FRANKIE)
    field = room.field((1.5, 0.0))
    way = field.way_from((-1.5, 0.0))
    assert room.clearance(way).min() > WIDTH / 2
    assert room.clearance((way[1:] + way[:-1]) / 2).min() > WIDTH / 2
    length = sum(float(np.hypot(*(b - a))) for a, b in pairwise(way))
    shortest = 2 * np.hypot(1.4, 2.3)
    assert shortest < length < 1.3 * shortest
    (cost,) = field.at(np.array([[-1.5, 0.0]]))
    assert length - 0.2 < cost < 1.6 * length
    (open_cost,) = field.at(np.array([[2.5, 1.0]]))
    assert open_cost == pytest.approx(np.hypot(1.0, 1.0), rel=0.1)


def test_a_gap_wider_than_the_base_is_a_way_and_a_narrower_one_is_not():
    around = (box(2, 4, 4.1, 0.1), box(2, -4, 4.1, 0.1), box(4, 0, 0.1, 8))
    for gap, passes in ((0.65, True), (0.45, False)):
        side = 2.0 + gap / 2.0
        walls = (box(0, side, 0.1, 4), box(0, -side, 0.1, 4))
        (cost,) = FloorMap((*walls, *around), FRANKIE).field((2.0, 0.0)).at(np.array([[-2.0, 0.0]]))
        assert np.isfinite(cost) == passes
