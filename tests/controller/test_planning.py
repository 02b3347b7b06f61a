"""The baseline: planned motion, on the real library."""

import numpy as np
import pytest
from pinocchio import SE3

from controller import (
    Command,
    PlanningController,
    PlanningSettings,
    PoseGoal,
    PostureGoal,
    Surroundings,
    robot_model,
)
from controller.collision.collision_model import CollisionModel
from lab.bench.evaluation import count_violations
from lab.bench.motion import State, run_motion
from robots import Box, Geom

pytest.importorskip("ompl", reason="the extra `planning` is not installed")

DOWN = np.diag([1.0, -1.0, -1.0])


def at(x: float, y: float, z: float) -> SE3:
    return SE3(DOWN, np.array([x, y, z]))


def go(goal, surroundings=None, planning=None, limit=40.0):
    """Simulate a planned motion; the controller, the motion and its reports."""
    model = robot_model("frankie")
    controller = PlanningController(model, planning=planning)
    around = surroundings or Surroundings()
    reports = []

    def step(*arguments):
        command, report = controller.step(*arguments)
        reports.append(report)
        return command, report

    motion = run_motion(
        step,
        model,
        lambda t: goal,
        period=0.01,
        limit=limit,
        patience=20.0,
        surroundings_at=lambda t: around,
        lag=True,
    )
    return motion, reports


def test_the_base_drives_first_and_the_arm_reaches_when_it_stands_within_all_limits():
    motion, reports = go(PoseGoal(wTe=at(3.0, 1.0, 0.6)))
    assert motion.arrived
    model = robot_model("frankie")
    drives = np.abs(motion.velocities[:, : model.n_base]).max(axis=1) > 0.02
    reaches = np.abs(motion.velocities[:, model.n_base :]).max(axis=1) > 0.02
    assert drives.any()
    assert reaches.any()
    assert not (drives & reaches).any()
    assert any(report.planning for report in reports)
    assert count_violations(model, motion) == 0


def test_the_same_goal_is_the_same_motion():
    pose = SE3(np.eye(3), np.array([0.75, 0.0, 0.75]))
    wall = Surroundings(fixtures=(Geom(Box((0.02, 0.3, 0.25)), pose, "wall"),))
    goal = PoseGoal(wTe=at(0.65, 0.45, 0.7))
    first, second = (go(goal, wall)[0] for _ in range(2))
    assert np.array_equal(first.q, second.q)


def test_the_arm_goes_around_what_stands_between():
    model = robot_model("frankie")
    start = model.description.arm.ready.copy()
    start[0] = 0.9
    post = Geom(Box((0.04, 0.04, 0.5)), SE3(np.eye(3), np.array([0.70, 0.0, 0.9])), "post")
    around = Surroundings(fixtures=(post,))
    goal = start.copy()
    goal[0] = -0.9
    shapes = CollisionModel(model, around)
    between = np.linspace(start, goal, 60)
    assert min(shapes.clearance(q) for q in between) < 0.0, "else there is nothing to go around"
    controller = PlanningController(model)
    state, command = State(wTb=SE3.Identity(), q=start), Command.stop(7)
    for _ in range(2000):
        command, report = controller.step(state, PostureGoal(q=goal), command, around)
        state = State(wTb=state.wTb, q=state.q + 0.01 * command.qd)
        assert shapes.clearance(state.q) > 0.0
        if report.arrived:
            break
    assert report.arrived


def test_planning_is_charged_as_time_that_the_robot_stands():
    goal = PoseGoal(wTe=at(0.6, 0.3, 0.7))
    quick, _ = go(goal, planning=PlanningSettings(planning_time=0.0))
    slow, reports = go(goal, planning=PlanningSettings(planning_time=1.0))
    assert sum(report.planning for report in reports) == 100
    assert slow.duration - quick.duration == pytest.approx(1.0, abs=0.02)


def test_what_is_out_of_reach_is_said():
    _, reports = go(PoseGoal(wTe=at(1.0, 0.0, 4.0)), limit=5.0)
    assert reports[-1].unreachable
    straight = PoseGoal(wTe=at(2.5, 0.0, 0.6), straight=True, hand_may_touch=True)
    motion, reports = go(straight, limit=5.0)
    assert "no way" in reports[-1].unreachable
    assert motion.tool[-1, 0] > motion.tool[0, 0] + 0.1, "as far as the arm gets"
