"""Where the hand points down the base may stand beside its goal, and need not turn for it."""

import numpy as np
import pytest
from motion import READY, run_to, tool_pose
from pinocchio import SE3

from controller import HolisticController, PoseGoal, RobotModel, SelfCollision
from controller.floor.base_drive import Pose2D
from controller.stance.posture_bank import bank
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance
from robots import load_robot, with_base_speeds

BEHIND = tool_pose(-2.5, 1.2, 0.85, yaw=np.pi / 2.0)
"""A place behind the robot and beside its way, the hand pointing down."""


@pytest.fixture(scope="module")
def both_ways() -> RobotModel:
    """Frankie with a base that backs as fast as it drives."""
    return RobotModel(with_base_speeds(load_robot("frankie"), 1.0, 1.0))


def stance_for(model: RobotModel, wTe: SE3, *, in_front: bool = False) -> Stance:
    where = bank(model.description), SelfCollision(model), wTe, Pose2D(0.0, 0.0, 0.0), READY
    stance = StanceSearch(model, *where, in_front=in_front).finish()
    assert stance is not None
    return stance


def test_a_base_that_backs_as_fast_as_it_drives_does_not_turn_to_a_goal_beside_its_way(both_ways):
    stance = stance_for(both_ways, BEHIND)
    assert stance.reverse
    assert abs(stance.base_for(BEHIND).heading) < 0.5
    assert stance.bearing > 0.8


def test_a_goal_that_a_base_follows_is_in_front_of_it(both_ways):
    assert abs(stance_for(both_ways, BEHIND, in_front=True).bearing) < 0.3


def headings_at(model: RobotModel, goals: list[PoseGoal]) -> list[float]:
    """Reach one goal after the other: the heading of the base at each of them [rad]."""
    controller, run, headings = HolisticController(model), None, []
    for goal in goals:
        before = {"state": run.state, "last": run.commands[-1]} if run else {}
        run = run_to(goal, controller=controller, seconds=15.0, **before)
        assert run.arrived
        headings.append(Pose2D.of(run.state.wTb).heading)
    return headings


def test_a_base_that_stands_beside_its_goal_does_not_turn_to_it_while_the_hand_goes_down(both_ways):
    down = SE3(BEHIND.rotation, BEHIND.translation - np.array([0.0, 0.0, 0.2]))
    goals = [PoseGoal(wTe=BEHIND), PoseGoal(wTe=down, straight=True)]
    above, below = headings_at(both_ways, goals)
    assert abs(above) < 0.5
    assert abs(below - above) < 0.15


def test_a_base_goes_on_to_the_stance_that_it_has_set_out_for(both_ways):
    """It is led there from the first period on: no search, in which it would come to rest."""
    controller = HolisticController(both_ways)
    here = both_ways.wTe(SE3.Identity(), READY)
    up = SE3(here.rotation, here.translation + np.array([0.0, 0.0, 0.1]))
    goal = PoseGoal(wTe=up, straight=True, next_goal=BEHIND)
    run = run_to(goal, controller=controller, seconds=0.3)
    assert run.reports[-1].stance is None
    _, report = controller.step(run.state, PoseGoal(wTe=BEHIND), run.commands[-1])
    assert report.stance is not None
