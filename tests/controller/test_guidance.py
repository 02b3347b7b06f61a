"""Guidance leads out of the local minima of the QP, and does no harm elsewhere."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from motion import Lagging, State, run_to, tool_pose
from pinocchio import SE3

from config.planar import ORIGIN, Pose2D
from controller import (
    Command,
    ControllerSettings,
    HolisticController,
    PoseGoal,
    RobotModel,
    SelfCollision,
    Surroundings,
    robot_model,
)
from controller.guidance import Guidance
from controller.guidance_states import Alone, Approaching, Event, Replacing, Unjudged
from controller.servo import pose_error
from controller.stance.bank_drawing import BANK, SEED, draw
from controller.stance.posture_bank import bank
from controller.stance.search import StanceSearch
from controller.stance.tool_poses import forward_kinematics
from robots import Box, Geom, at_pace, load_robot, robot_names

READY = load_robot("frankie").arm.ready

BARE = replace(ControllerSettings(), guidance=False)


def precisely(mTe: SE3) -> PoseGoal:
    return PoseGoal(target=mTe, position_tolerance=0.01, orientation_tolerance=np.deg2rad(1.0))


def test_a_goal_where_the_qp_alone_gets_stuck_is_reached():
    mTe = SE3(pin.rpy.rpyToMatrix(1.105, 0.481, -1.552), np.array([1.576, 2.703, 1.024]))
    goal, alone = precisely(mTe), HolisticController(robot_model("frankie"), BARE)
    assert not run_to(goal, seconds=10.0, controller=alone).arrived
    assert run_to(goal).arrived


def test_a_slow_arm_unfolds_past_its_singular_postures():
    mTe = SE3(pin.rpy.rpyToMatrix(2.0454, -0.4784, -0.4301), np.array([-3.455, 1.714, 0.811]))
    slow = HolisticController(RobotModel(at_pace(load_robot("frankie"), 0.3)))
    assert run_to(precisely(mTe), seconds=25.0, controller=slow).arrived


def test_a_stance_that_failed_is_not_chosen_again():
    model = robot_model("frankie")
    body, mTe = SelfCollision(model), tool_pose(2.0, 0.5, 0.7)
    here = (model, bank(model.description), body, mTe, ORIGIN, READY)
    first = StanceSearch(*here).finish()
    second = StanceSearch(*here, failed=(first,)).finish()
    assert np.abs(first.q - second.q).max() > 0.5


def guide_and_ask():
    model = robot_model("frankie")
    guide = Guidance(model, ControllerSettings(), SelfCollision(model))

    def ask(goal: PoseGoal, state: State):
        """What the guide says as soon as it knows."""
        error = pose_error(model.end_effector(state.mTb, state.q), goal.target)
        while True:
            guided = guide.step(goal, error, Pose2D.of(state.mTb), state.q)
            if not guide.rests:
                return guided

    return guide, ask


def test_the_page_draws_the_transitions_of_guidance():
    page = (Path(__file__).parents[2] / "docs/controller.md").read_text("utf-8")
    drawn = set(re.findall(r"^    (\S+) --> (\S+): (.+)$", page, re.MULTILINE))
    assert drawn == {
        ("[*]" if before is Unjudged else before.__name__, after.__name__, event.words)
        for event in Event
        for before, after in event.changes.items()
    }


def test_a_robot_that_makes_no_progress_tries_a_detour_within_about_a_second():
    _, ask = guide_and_ask()
    goal, state = PoseGoal(target=tool_pose(0.75, 0.05, 0.7)), State()  # near: no guidance at first
    biases = [ask(goal, state).bias for _ in range(110)]
    assert biases[0] is None
    assert biases[-1].blend == 1.0
    assert biases[-1].min_tracking == 0.0  # the end effector waits


def test_a_robot_that_gets_nowhere_tries_its_detours_and_then_the_end_effector_alone():
    guide, ask = guide_and_ask()
    goal, states = PoseGoal(target=tool_pose(3.0, 0.0, 0.7)), []
    for _ in range(440):
        ask(goal, State())
        if not states or type(guide.state) is not type(states[-1]):
            states.append(guide.state)
    assert [type(state) for state in states] == [Approaching, *[Replacing, Approaching] * 3, Alone]
    led = [state for state in states if isinstance(state, Approaching)]
    assert [state.is_detour for state in led] == [False, True, True, True]
    assert len({id(state.stance) for state in led}) == 4


def test_a_base_that_stands_on_its_way_is_stuck_though_the_arm_moves_on():
    model = robot_model("frankie")
    guide = Guidance(model, ControllerSettings(), SelfCollision(model))
    wall = Geom(Box((0.1, 2.0, 0.5)), SE3(np.eye(3), np.array([1.5, 0.5, 0.5])), "wall")
    goal, around, q = (
        PoseGoal(target=tool_pose(3.0, 0.0, 0.7)),
        Surroundings(fixtures=(wall,)),
        READY,
    )
    tried = []
    for _ in range(250):
        error = pose_error(model.end_effector(SE3.Identity(), q), goal.target)
        guide.step(goal, error, ORIGIN, q, around)
        if guide.stance is not None:
            tried.append(guide.stance)
            q = q + 0.01 * (guide.stance.q - q)
    assert tried[-1] is not tried[20]
    assert np.abs(tried[20].q - q).max() > 0.01


def test_a_goal_that_is_near_gets_a_stance_where_that_is_asked_for():
    _, ask = guide_and_ask()
    goal = PoseGoal(target=tool_pose(0.75, 0.05, 0.7), stance_if_near=True)
    guided = ask(goal, State())
    assert guided.bias is not None
    assert guided.base is not None
    guided = ask(replace(goal, target=tool_pose(0.75, 0.25, 0.7), straight=True), State())
    assert guided.base is None  # straight is straight


def test_a_goal_that_creeps_keeps_its_stance_and_one_that_jumps_gets_another():
    _, ask = guide_and_ask()
    state, velocities = State(), []
    for x in np.linspace(3.0, 3.2, 40):
        velocities.append(ask(PoseGoal(target=tool_pose(x, 0.0, 0.7)), state).bias.pull[2:])
    one_direction = velocities[-1] / velocities[0]
    np.testing.assert_allclose(one_direction, one_direction[0], rtol=1e-6)
    elsewhere = ask(PoseGoal(target=tool_pose(-3.0, 1.0, 1.2, yaw=2.0)), state).bias.pull[2:]
    assert np.abs(elsewhere - velocities[-1]).max() > 0.05


@pytest.mark.parametrize(
    ("robot", "x", "y", "yaw"), [("frankie", 2.5, -1.0, 1.5), ("omni", -1.0, 0.5, 2.0)]
)
def test_going_down_on_a_grasp_is_straight_though_the_base_follows_late(robot, x, y, yaw):
    """The base still brakes when the hand goes down, and is faster than it is told."""
    above, grasp = tool_pose(x, y, 0.5, yaw), tool_pose(x, y, 0.38, yaw)
    model = robot_model(robot)
    controller, late, last = HolisticController(model), Lagging(model), Command.stop(7)

    def go(goal):
        nonlocal last
        for _ in range(1000):
            last, report = controller.step(late.state, goal, last)
            if report.arrived:
                return
            late.follow(last)
            yield model.end_effector(late.state.mTb, late.state.q).translation - grasp.translation
        pytest.fail("it does not arrive")

    for _ in go(PoseGoal(target=above, position_tolerance=0.006)):
        pass
    way = list(go(PoseGoal(target=grasp, speed=0.25, position_tolerance=0.004, straight=True)))
    aside = [float(np.hypot(dx, dy)) for dx, dy, above in way if above < 0.04]
    assert len(way) < 100
    assert max(aside) < 0.003


def test_the_stored_bank_is_what_its_seed_draws():
    stored = np.load(BANK)
    again = draw(
        [load_robot(name) for name in ("frankie", "omni")], 500, np.random.default_rng(SEED)
    ).astype(np.float16)
    np.testing.assert_array_equal(stored[:500], again)


@pytest.mark.parametrize("robot", robot_names())
def test_forward_kinematics_of_many_postures_is_that_of_each(robot):
    model = robot_model(robot)
    q = bank(model.description).q[::5000]
    tools = forward_kinematics(model.description, q)
    for number, posture in enumerate(q):
        kinematics = model.kinematics(posture)
        np.testing.assert_allclose(tools.positions[number], kinematics.bTe.translation, atol=1e-12)
        np.testing.assert_allclose(tools.rotations[number], kinematics.bTe.rotation, atol=1e-12)
        np.testing.assert_allclose(tools.J[number], kinematics.J[:, model.n_base :], atol=1e-12)
