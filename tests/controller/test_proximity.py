"""Distances that are kept from step to step are those that are measured anew."""

import numpy as np
import pytest
from motion import proximity, tool_pose
from pinocchio import SE3

from controller import (
    Command,
    HolisticController,
    Obstacle,
    PoseGoal,
    Surroundings,
    robot_model,
)
from controller.collision.proximity import Distances
from robots import Box, Cylinder, Geom

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


def assert_same(ours: Distances, fresh: Distances) -> None:
    """As exactly as Coal measures, which begins where it ended the last time."""
    np.testing.assert_array_equal(ours.pair, fresh.pair)
    np.testing.assert_allclose(ours.d, fresh.d, atol=1e-5)
    np.testing.assert_allclose(ours.rows, fresh.rows, atol=1e-2)


@pytest.mark.parametrize("walked", [False, True])
def test_what_is_picked_up_and_put_down_leaves_the_other_distances(model, walked):
    kept, q = proximity(model), model.description.arm.ready.copy()
    slow, seen = np.full(model.n, 0.2), 0
    for step in range(90):
        wTb = SE3(np.eye(3), np.array([0.004 * step, 0.0, 0.0]))
        q[0] += 0.01
        known = Surroundings(
            fixtures=TABLE,
            held=ROD if 30 <= step < 60 else (),
            loose=CAN if step >= 60 else (),
            moving=(walker(step),) if walked else (),
        )
        ours, fresh = (p.near(wTb, q, known, slow) for p in (kept, proximity(model)))
        assert_same(ours, fresh)
        seen += len(ours.d)
    assert seen > 200


def test_a_robot_that_comes_from_afar_measures_in_time(model):
    """On the way nothing is near at any speed, and distances are not looked at at all."""
    kept, q, fast = proximity(model), model.description.arm.ready, np.full(model.n, 1.0)
    seen = []
    for step in range(120):
        wTb = SE3(np.eye(3), np.array([-3.0 + 0.03 * step, 0.0, 0.0]))
        known = Surroundings(fixtures=TABLE)
        ours, fresh = (p.near(wTb, q, known, fast) for p in (kept, proximity(model)))
        assert_same(ours, fresh)
        seen.append(len(ours.d))
    assert seen[0] == 0
    assert seen[-1] > 0


def test_what_is_prepared_changes_nothing_but_the_time(model):
    """The same commands, bit for bit, and the same reports."""
    around, goal = Surroundings(fixtures=TABLE), PoseGoal(wTe=tool_pose(1.2, 0.0, 0.7))
    runs = []
    for prepared in (False, True):
        controller, last = HolisticController(model), Command.stop()
        if prepared:
            controller.prepare(around)
        state = type("State", (), {"wTb": SE3.Identity(), "q": model.description.arm.ready})()
        steps = []
        for _ in range(60):
            last, report = controller.step(state, goal, last, around)
            state.wTb = state.wTb * SE3(np.eye(3), 0.01 * last.base_twist * [1.0, 1.0, 0.0])
            state.q = state.q + 0.01 * last.qd
            steps.append([*last.base_twist, *last.qd, report.near_pairs, report.clearance])
        runs.append(steps)
    np.testing.assert_array_equal(*runs)
    assert max(step[-2] for step in runs[0]) > 0
