"""Object classes with curved and hollow bodies, and random bodies."""

import numpy as np
import pytest
from pinocchio import SE3, exp3

from hw.sim import GraspOutcome, Hand, Reason, SimObject, World
from hw.sim.contact import separation
from hw.sim.objects import MODELLED
from hw.sim.objects.making import make_object
from hw.sim.objects.modelling import SIDES, hollow, turned
from robots import Geom, Plane, hull_of, load_robot, volume

FLOOR = Geom(Plane(), SE3.Identity(), "floor")
UP = np.array([0.0, 0.0, 1.0])
DOWN = np.diag([1.0, -1.0, -1.0])
GRIPPER = load_robot("frankie").gripper
POLYGON = SIDES / 2.0 * np.sin(2.0 * np.pi / SIDES)  # area of the polygon in the unit circle


def made(name: str, width: float, seed: int = 0) -> SimObject:
    ranges = (width, width), (0.05, 0.2)
    return make_object("it", MODELLED[name], *ranges, np.random.default_rng(seed))


def closed_on(obj: SimObject, point: np.ndarray, yaw: float = 0.0) -> tuple[World, GraspOutcome]:
    """A world after the fingers have closed at a point of it, and what that led to."""
    world = World([FLOOR], [obj])
    hand = Hand(GRIPPER, SE3(exp3(yaw * UP) @ DOWN, point))
    return world, world.close_fingers(hand, GRIPPER.opening, 30.0)


def closed_on_rims(name: str, width: float) -> list[tuple[SimObject, Reason]]:
    """Objects and what became of them when fingers closed on their rims, all round."""
    found = []
    for number, angle in enumerate(np.linspace(0.1, 2.0 * np.pi + 0.1, 10, endpoint=False)):
        obj = made(name, width, seed=number % 5)
        axis = obj.placed()[0].pose.translation[:2]  # of the bottom
        rim = obj.reach(np.array([0.0, 1.0, 0.0])) - 0.004
        place = axis + rim * np.array([np.cos(angle), np.sin(angle)])
        point = np.array([*place, obj.reach(UP) - 0.01])
        found.append((obj, closed_on(obj, point, angle - np.pi / 2.0)[1].reason))
    return found


def test_a_turned_body_is_cut_where_it_is_waisted_only():
    assert len(turned([(0.0, 0.02), (0.05, 0.03), (0.1, 0.02)])) == 1
    waisted = turned([(0.0, 0.03), (0.05, 0.02), (0.1, 0.03)])
    assert len(waisted) == 2
    cone = 0.05 * POLYGON * (0.03**2 + 0.03 * 0.02 + 0.02**2) / 3.0
    assert sum(volume(part.shape) for part in waisted) == pytest.approx(2.0 * cone)


def test_a_hollow_body_has_a_wall_and_a_bottom():
    parts = hollow([(0.0, 0.04), (0.1, 0.04)], 0.004)
    wall = POLYGON * (0.04**2 - 0.036**2) * 0.096
    total = sum(volume(part.shape) for part in parts)
    assert wall < total - POLYGON * 0.04**2 * 0.004 < 1.2 * wall
    water = hull_of(np.concatenate([0.035 * ring_at(z) for z in (0.005, 0.1)]))
    assert all(separation(part, water)[0] > 0.0 for part in parts)


def ring_at(height: float) -> np.ndarray:
    """Corners (8, 3) of an octagon in the circle of radius 1; heights are scaled with it."""
    angles = np.arange(8) * np.pi / 4.0
    return np.stack([np.cos(angles), np.sin(angles), np.full(8, height / 0.035)], axis=1)


def test_a_bottle_is_held_across_its_body_and_a_mug_by_handle_and_rim():
    bottle = made("bottle", 0.05)
    _, outcome = closed_on(bottle, bottle.pose.translation)
    assert outcome.reason is Reason.HELD
    assert outcome.width == pytest.approx(0.05, abs=1e-3)
    mug = made("coffee mug", 0.06)
    x = mug.reach(np.array([1.0, 0.0, 0.0])) - 0.006
    world, outcome = closed_on(mug, np.array([x, 0.0, 0.5 * mug.reach(UP)]))
    assert world.held is mug
    assert 0.009 < outcome.width < 0.015
    reasons = [reason for _, reason in closed_on_rims("coffee mug", 0.06)]
    assert reasons.count(Reason.HELD) >= 4


def test_a_bowl_that_the_pads_tilt_does_not_sink_into_the_floor():
    closed = closed_on_rims("bowl", 0.007)
    held = [obj for obj, reason in closed if reason is Reason.HELD]
    assert len(held) >= 2
    assert max(obj.reach(-UP) for obj in held) < 1e-6
    assert any(obj.pose.rotation[2, 2] < 0.999 for obj in held)
