"""A base that is slower backwards than forwards keeps that limit, plans with it, and arrives."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from motion import Run, run_to, tool_pose
from pinocchio import SE3

from controller import BaseGoal, HolisticController, PoseGoal, RobotModel
from robots import load_robot, with_base_speeds

FRANKIE, OMNI = with_base_speeds(load_robot("frankie"), reverse=1.0), load_robot("omni")
SLOW = 0.25


@pytest.fixture(params=[FRANKIE, OMNI], ids=lambda robot: robot.name)
def model(request) -> RobotModel:
    limits = replace(request.param.limits, base_reverse=SLOW)
    return RobotModel(replace(request.param, limits=limits))


def base_pose(x: float, y: float, heading: float) -> SE3:
    return SE3(pin.utils.rotate("z", heading), np.array([x, y, 0.0]))


def slowest(run: Run) -> float:
    """Base velocity along x that is farthest below zero [m/s]."""
    return min(float(command.base_twist[0]) for command in run.commands)


@pytest.mark.parametrize("target", [(-1.0, 0.5, 0.6), (-0.12, 0.0, 0.0)])
def test_the_base_backs_to_a_pose_no_faster_than_it_may(model, target):
    goal = BaseGoal(wTb=base_pose(*target), reverse=True)
    run = run_to(goal, seconds=30.0, controller=HolisticController(model))
    assert run.arrived
    assert -SLOW <= slowest(run) < -0.1


def test_a_differential_drive_prefers_to_turn_where_backing_is_slow():
    """The same goal behind: with one speed it backs, with a slow reverse it turns around."""
    goal = PoseGoal(wTe=tool_pose(-2.4, 0.0, 0.6))
    slow = RobotModel(replace(FRANKIE, limits=replace(FRANKIE.limits, base_reverse=SLOW)))
    backed = run_to(goal, controller=HolisticController(RobotModel(FRANKIE)))
    turned = run_to(goal, controller=HolisticController(slow))
    assert backed.arrived
    assert turned.arrived
    assert slowest(backed) < -0.9
    assert slowest(turned) > -SLOW
    assert len(turned.reports) * 0.01 < 8.0  # 2 m backwards alone would take 8 s
