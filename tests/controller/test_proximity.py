"""Distances of the robot to itself, to things and to seen points, and how they grow."""

import numpy as np
import pinocchio as pin
import pytest
from motion import proximity, run_to, tool_pose
from pinocchio import SE3

from controller import (
    OPEN_FLOOR,
    HolisticController,
    Obstacle,
    PointCloud,
    PoseGoal,
    SelfCollision,
    Surroundings,
    robot_model,
)
from controller.collision.collision_model import CollisionModel, PairKind
from controller.collision.proximity import Distances, Proximity, Ranges
from robots import Box, Capsule, Cylinder, Geom, Sphere, from_rounded_boxes, rounded_box

TABLE = (
    Geom(Box((0.3, 0.5, 0.02)), SE3(np.eye(3), np.array([1.2, 0.0, 0.5])), "table/top"),
    Geom(Cylinder(0.05, 0.25), SE3(np.eye(3), np.array([0.9, 0.4, 0.25])), "table/leg"),
)


ROD = (Geom(Box((0.02, 0.02, 0.15)), SE3(np.eye(3), np.array([0.0, 0.0, 0.12])), "held"),)


CAN = (Geom(Cylinder(0.03, 0.05), SE3(np.eye(3), np.array([1.0, 0.0, 0.57])), "can"),)


@pytest.fixture(params=["frankie", "omni"])
def model(request):
    return robot_model(request.param)


def walker(step: int) -> Obstacle:
    centre = np.array([2.5 - 0.01 * step, 0.0, 0.85])
    geom = Geom(Cylinder(0.25, 0.85), SE3(np.eye(3), centre), "walker")
    return Obstacle(geom, np.array([-1.0, 0.0, 0.0]))


CLOUDS = tuple(
    PointCloud(np.random.default_rng(seed).uniform([-0.6, -0.8, 0.45], [1.2, 0.8, 1.4], (300, 3)))
    for seed in (1, 2)
)
"""Points beside, before and above the base, in two pictures."""


def assert_same(ours: Distances, fresh: Distances) -> None:
    """As exactly as Coal measures, which begins where it ended the last time."""
    np.testing.assert_array_equal(ours.pair, fresh.pair)
    np.testing.assert_allclose(ours.d, fresh.d, atol=1e-5)
    np.testing.assert_allclose(ours.rows, fresh.rows, atol=1e-2)


@pytest.mark.parametrize(("walked", "sees"), [(False, False), (True, False), (False, True)])
def test_what_is_picked_up_and_put_down_leaves_the_other_distances(model, walked, sees):
    kept, q = proximity(model), model.description.arm.ready.copy()
    slow, seen = np.full(model.n, 0.2), 0
    for step in range(90):
        mTb = SE3(np.eye(3), np.array([0.004 * step, 0.0, 0.0]))
        q[0] += 0.01
        known = Surroundings(
            fixtures=TABLE,
            held=ROD if 30 <= step < 60 else (),
            loose=CAN if step >= 60 else (),
            depth_points=CLOUDS[step >= 30] if sees else None,
            moving=(walker(step),) if walked else (),
        )
        ours, fresh = (p.near(mTb, q, known, slow) for p in (kept, proximity(model)))
        assert_same(ours, fresh)
        seen += len(ours.d)
    assert seen > 200


AROUND = np.random.default_rng(0).uniform([-0.6, -0.8, 0.45], [1.2, 0.8, 1.4], (300, 3))
"""Points beside, before and above the base."""


def near(model, q, mTb=None, **known):
    fastest = np.abs(model.velocity_limits).max(axis=0)
    return proximity(model).near(mTb or SE3.Identity(), q, Surroundings(**known), fastest)


def by_name(model, known) -> dict[str, np.ndarray]:
    """The distances of each part of the robot to what stands around, by its name."""
    prox, q = proximity(model), model.description.arm.ready
    found = prox.near(SE3.Identity(), q, known, np.abs(model.velocity_limits).max(axis=0))
    found = found.without(PairKind.SELF)
    names = np.array([prox.pair_name(int(pair)).split(" and ")[0] for pair in found.pair])
    return {name: found.d[names == name] for name in set(names)}


def test_points_are_as_near_to_every_link_as_coal_says(model):
    points = AROUND[:200]
    balls = tuple(Geom(Sphere(1e-5), SE3(np.eye(3), p), f"{k}") for k, p in enumerate(points))
    ours = by_name(model, Surroundings(depth_points=PointCloud(points)))
    coals = by_name(model, Surroundings(fixtures=balls))
    assert set(ours) >= {"base", "link1", "link3", "link5", "link7", "hand", "camera"}
    for name, distances in ours.items():
        measured = distances + 0.01  # what may stand between the points is taken off
        assert measured.min() < coals[name].min() + 0.01, name
        off = np.abs(measured[:, None] - coals[name]).min(axis=1)
        assert off.max() < 1e-4, name


def test_rows_are_the_rates_at_which_distances_grow(model):
    cloud, q = PointCloud(AROUND), model.description.arm.ready
    start, step = near(model, q, depth_points=cloud), 1e-6
    assert len(start.d) > 10
    for number in range(model.n):
        moved = np.zeros(model.n)
        moved[number] = step
        twist = model.command(moved).base_twist
        mTb = pin.exp6(np.array([twist[0], twist[1], 0.0, 0.0, 0.0, twist[2]]))
        after = near(model, q + moved[model.n_base :], mTb, depth_points=cloud)
        rates = (after.d - start.d) / step
        np.testing.assert_allclose(rates, start.rows[:, number], atol=1e-4)


def test_distances_from_rounded_boxes():
    points = np.array([[0.3, 0.0, 0.0], [0.0, 0.0, 0.5], [0.05, 0.0, 0.0], [0.2, 0.3, 0.0]])
    d, out = from_rounded_boxes(points, *rounded_box(Box((0.1, 0.2, 0.3))))
    np.testing.assert_allclose(d, [0.2, 0.2, -0.05, np.hypot(0.1, 0.1)])
    np.testing.assert_allclose(out[:3], [[1, 0, 0], [0, 0, 1], [1, 0, 0]])
    d, _ = from_rounded_boxes(points, *rounded_box(Capsule(0.1, 0.2)))
    np.testing.assert_allclose(d[:3], [0.2, 0.2, -0.05])


def test_growth_of_a_distance_is_its_derivative(model):
    rng, body, checked = np.random.default_rng(1), CollisionModel(model), 0
    kinds = np.ones(len(PairKind))
    within = Ranges(0.1, 0.0 * kinds, kinds, 0.1 * kinds)
    while checked < 30:
        q = rng.uniform(model.limits.q_min, model.limits.q_max)
        distance = body.clearance(q)
        if not 0.01 < distance < 0.1:
            continue
        near = Proximity(model, within).near(SE3.Identity(), q, OPEN_FLOOR, np.zeros(model.n))
        nearest = int(near.d.argmin())
        assert near.d[nearest] == pytest.approx(distance)
        move_by = rng.normal(size=7) * 1e-5
        grown = (body.clearance(q + move_by) - body.clearance(q - move_by)) / 2.0
        row = near.rows[nearest, model.n_base :]
        assert grown == pytest.approx(float(row @ move_by), abs=2e-7)
        checked += 1


@pytest.mark.parametrize("straight", [True, False])
def test_the_hand_stops_before_the_floor_when_it_is_sent_through_it(model, straight):
    body, goal = (
        SelfCollision(model),
        PoseGoal(target=tool_pose(0.75, 0.0, -0.015), straight=straight),
    )
    run = run_to(goal, controller=HolisticController(model), seconds=5.0)
    assert min(body.clearance(state.q) for state in run.states) > 0.0
    assert not straight or model.end_effector(run.state.mTb, run.state.q).translation[2] < 0.15
