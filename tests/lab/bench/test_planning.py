"""The baseline: planned motion, on the real library."""

import numpy as np
import pytest
from pinocchio import SE3

from controller import Command, KinematicState, PoseGoal, PostureGoal, Surroundings, robot_model
from controller.collision.collision_model import CollisionModel
from lab.bench.motion_evaluation import count_violations
from lab.bench.planning import PlanningController, PlanningSettings
from lab.bench.simulated_motion import run_motion
from robots import Box, Geom

pytest.importorskip("ompl", reason="the extra `planning` is not installed")

DOWN = np.diag([1.0, -1.0, -1.0])


def at(x: float, y: float, z: float) -> SE3:
    return SE3(DOWN, np.array([x, y, z]))


def go(goal, surroundings=None, planning=None, limit=40.0):
    """Simulate a planned motion; the motion, its reports, and in which periods it was planned."""
    model = robot_model("frankie")
    controller, reports, planned = PlanningController(model, planning), [], []
    around = surroundings or Surroundings()

    def step(*arguments):
        command, report = controller.step(*arguments)
        reports.append(report)
        planned.append(controller.is_planning)
        return command, report

    options = {"period": 0.01, "limit": limit, "patience": 20.0, "lag": True}
    motion = run_motion(step, model, lambda t: goal, surroundings_at=lambda t: around, **options)
    return motion, reports, planned


def test_the_base_drives_first_and_the_arm_reaches_when_it_stands_within_all_limits():
    motion, _, planned = go(PoseGoal(target=at(3.0, 1.0, 0.6)))
    assert motion.arrived
    model = robot_model("frankie")
    drives = np.abs(motion.velocities[:, : model.n_base]).max(axis=1) > 0.02
    reaches = np.abs(motion.velocities[:, model.n_base :]).max(axis=1) > 0.02
    assert drives.any()
    assert reaches.any()
    assert not (drives & reaches).any()
    assert any(planned)
    assert count_violations(model, motion) == 0


def test_the_same_goal_is_the_same_motion():
    pose = SE3(np.eye(3), np.array([0.75, 0.0, 0.75]))
    wall = Surroundings(fixtures=(Geom(Box((0.02, 0.3, 0.25)), pose, "wall"),))
    goal = PoseGoal(target=at(0.65, 0.45, 0.7))
    first, second = (go(goal, wall)[0] for _ in range(2))
    assert np.array_equal(first.q, second.q)


def test_the_arm_goes_around_what_stands_between():
    model = robot_model("frankie")
    start, goal = (np.array([turn, *model.description.arm.ready[1:]]) for turn in (0.9, -0.9))
    post = Geom(Box((0.04, 0.04, 0.5)), SE3(np.eye(3), np.array([0.70, 0.0, 0.9])), "post")
    around = Surroundings(fixtures=(post,))
    shapes = CollisionModel(model, around)
    between = np.linspace(start, goal, 60)
    assert min(shapes.clearance(q) for q in between) < 0.0, "else there is nothing to go around"
    controller = PlanningController(model)
    state, command = KinematicState(mTb=SE3.Identity(), q=start), Command.stop(7)
    for _ in range(2000):
        command, report = controller.step(state, PostureGoal(q=goal), command, around)
        state = KinematicState(mTb=state.mTb, q=state.q + 0.01 * command.qd)
        assert shapes.clearance(state.q) > 0.0
        if report.arrived:
            break
    assert report.arrived


def test_planning_is_charged_as_time_that_the_robot_stands():
    goal = PoseGoal(target=at(0.6, 0.3, 0.7))
    quick, *_ = go(goal, planning=PlanningSettings(planning_time=0.0))
    slow, _, planned = go(goal, planning=PlanningSettings(planning_time=1.0))
    assert sum(planned) == 100
    assert slow.duration - quick.duration == pytest.approx(1.0, abs=0.02)


def test_what_is_out_of_reach_is_said():
    _, reports, _ = go(PoseGoal(target=at(1.0, 0.0, 4.0)), limit=5.0)
    assert reports[-1].unreachable
    straight = PoseGoal(target=at(2.5, 0.0, 0.6), straight=True, hand_may_touch=True)
    motion, reports, _ = go(straight, limit=5.0)
    assert "no way" in reports[-1].unreachable
    assert motion.tool[-1, 0] > motion.tool[0, 0] + 0.1, "as far as the arm gets"
