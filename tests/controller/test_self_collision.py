"""Distances between the parts of the robot, and how they grow."""

import numpy as np
import pytest
from motion import run_to, tool_pose
from pinocchio import SE3

from controller import OPEN_FLOOR, HolisticController, PoseGoal, SelfCollision, robot_model
from controller.collision.collision_model import CollisionModel, PairKind
from controller.collision.proximity import Proximity, Ranges
from robots import load_robot

READY = load_robot("frankie").arm.ready


def proximity(model, within: float) -> Proximity:
    """Of a robot for which pairs matter that are nearer than `within` [m]."""
    kinds = np.ones(len(PairKind))
    return Proximity(model, Ranges(within, 0.0 * kinds, kinds, within * kinds))


@pytest.fixture(params=["frankie", "omni"])
def model(request):
    return robot_model(request.param)


def test_growth_of_a_distance_is_its_derivative(model):
    rng, body, checked = np.random.default_rng(1), CollisionModel(model), 0
    while checked < 30:
        q = rng.uniform(model.limits.q_min, model.limits.q_max)
        distance = body.clearance(q)
        if not 0.01 < distance < 0.1:
            continue
        near = proximity(model, 0.1).near(SE3.Identity(), q, OPEN_FLOOR, np.zeros(model.n))
        nearest = int(near.d.argmin())
        assert near.d[nearest] == pytest.approx(distance)
        move_by = rng.normal(size=7) * 1e-5
        grown = (body.clearance(q + move_by) - body.clearance(q - move_by)) / 2.0
        row = near.rows[nearest, model.n_base :]
        assert grown == pytest.approx(float(row @ move_by), abs=2e-7)
        checked += 1


@pytest.mark.parametrize("straight", [True, False])
def test_the_hand_stops_before_the_floor_when_it_is_sent_through_it(model, straight):
    body, goal = SelfCollision(model), PoseGoal(wTe=tool_pose(0.75, 0.0, -0.015), straight=straight)
    run = run_to(goal, controller=HolisticController(model), seconds=5.0)
    assert min(body.clearance(state.q) for state in run.states) > 0.0
    assert not straight or model.wTe(run.state.wTb, run.state.q).translation[2] < 0.15
