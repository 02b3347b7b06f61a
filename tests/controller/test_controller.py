"""The controller in a loop: it arrives, keeps every limit, reverse too, and refuses nonsense."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motion import READY, Run, State, run_to, tool_pose
from pinocchio import SE3

from controller import (
    BaseGoal,
    Command,
    ControllerSettings,
    GoalError,
    HolisticController,
    PoseGoal,
    PostureGoal,
    RobotModel,
    robot_model,
)
from controller.qp_solver import Solver
from controller.settings import JointLimitSettings
from controller.velocity_bounds import VelocityBounds
from robots import load_robot, with_base_speeds

ROBOTS = ["frankie", "omni"]


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize(
    "mTe", [tool_pose(-2.0, 1.0, 0.6, yaw=np.pi, tilt=0.3), tool_pose(0.7, 0.1, 0.6, yaw=0.5)]
)
def test_reaches_position_and_orientation_within_all_limits(robot, mTe):
    run = run_to(PoseGoal(target=mTe), robot=robot)
    assert run.arrived
    reached = robot_model(robot).end_effector(run.state.mTb, run.state.q)
    assert np.linalg.norm(reached.translation - mTe.translation) <= 0.01
    assert np.linalg.norm(pin.log3(reached.rotation.T @ mTe.rotation)) <= np.deg2rad(2.0)


def test_keeps_the_hand_still_while_the_base_finds_its_place():
    """Arrived, the controller goes on improving the posture, without leaving the goal."""
    goal = PoseGoal(target=tool_pose(1.5, 0.4, 0.7))
    run = run_to(goal, seconds=8.0, stays=True)
    arrived = [report.arrived for report in run.reports].index(True)
    assert len(run.reports) - arrived > 300
    assert max(report.position_error for report in run.reports[arrived:]) < 0.01


def test_the_arm_goes_down_alone_where_the_base_shall_rest():
    above = tool_pose(1.5, 0.2, 0.9, tilt=-0.7)
    before = run_to(PoseGoal(target=above), seconds=2.0)  # the base still drives
    down = above * SE3(np.eye(3), np.array([0.0, 0.0, 0.12]))

    def way(*, base_rests: bool) -> float:
        goal = PoseGoal(target=down, straight=True, speed=0.25, base_rests=base_rests)
        run = run_to(goal, state=before.state, last=before.commands[-1])
        assert run.arrived
        return float(np.linalg.norm(before.state.mTb.actInv(run.state.mTb.translation)))

    assert way(base_rests=True) < 0.5 * way(base_rests=False)


def test_without_a_goal_it_brakes_to_rest_within_the_acceleration_limits():
    moving = Command(base_twist=np.array([0.9, 0.0, -0.8]), qd=np.full(7, 1.0))
    run = run_to(None, last=moving, seconds=1.0)
    assert not robot_model("frankie").velocities(run.commands[-1]).any()


def test_a_posture_is_reached_by_all_joints_together_with_the_base_held():
    goal = PostureGoal(q=READY + np.array([0.5, -0.4, 0.3, 0.6, -0.2, 0.7, -0.1]))
    run = run_to(goal)
    assert run.arrived
    np.testing.assert_allclose(run.state.q, goal.q, atol=goal.tolerance)
    assert run.state.mTb.isApprox(SE3.Identity())


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("target", [(-1.0, 0.5, 1.2), (0, 0, 2)])
def test_the_base_drives_to_a_pose_with_the_arm_held(robot, target):
    x, y, heading = target
    mTb = SE3(pin.rpy.rpyToMatrix(0.0, 0.0, float(heading)), np.array([x, y, 0.0]))
    run = run_to(BaseGoal(target=mTb), robot=robot, seconds=30.0)
    assert run.arrived
    np.testing.assert_array_equal(run.state.q, READY)


@cache
def kept_controller(robot: str) -> HolisticController:
    """Not a new one for every case: what a case leaves behind must not harm the next."""
    return HolisticController(robot_model(robot))


@settings(max_examples=100, deadline=None)
@given(
    robot=st.sampled_from(ROBOTS),
    seed=st.integers(0, 2**31),
    scale=st.sampled_from([1e-9, 1e-3, 1.0, 1.0, 3.0, 1e3, 1e9]),
)
def test_every_finite_input_gives_a_finite_command_within_limits(robot, seed, scale):
    """A random state, velocity and goal, the goal jumping in between."""
    rng, controller = np.random.default_rng(seed), kept_controller(robot)
    model = controller.model
    q = rng.uniform(model.limits.q_min - 0.3, model.limits.q_max + 0.3)
    mTb = SE3(pin.utils.rotate("z", rng.uniform(-9, 9)), np.array([*rng.normal(size=2), 0.0]))
    last = model.command(rng.uniform(*model.velocity_limits))
    for _ in range(2):
        mTe = SE3(pin.exp3(rng.normal(size=3) * 2.0), rng.normal(size=3) * scale)
        goal = PoseGoal(target=mTe, twist=rng.normal(size=6) * rng.choice([0.0, 0.3]))
        command, report = controller.step(State(mTb=mTb, q=q), goal, last)
        assert command.is_finite()
        assert report.solved
        velocities = model.velocities(command)
        step = np.abs(velocities - model.velocities(last))
        assert (step <= model.acceleration_limits * 0.01 + 1e-12).all()
        assert (velocities >= model.velocity_limits[0] - 1e-12).all()
        assert (velocities <= model.velocity_limits[1] + 1e-12).all()
        faster = np.where(q > model.limits.q_max, command.qd > np.maximum(last.qd, 0.0), False)
        slower = np.where(q < model.limits.q_min, command.qd < np.minimum(last.qd, 0.0), False)
        assert not (faster | slower).any(), "deeper into a limit"
        last = command


@settings(max_examples=150, deadline=None)
@given(numbers=st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=20, max_size=20))
def test_any_numbers_at_all_are_answered_within_limits_or_refused(numbers):
    controller = kept_controller("frankie")
    model, stop = controller.model, Command.stop(7)
    goal = PoseGoal(target=tool_pose(*numbers[7:10]), twist=np.array(numbers[10:16]))
    try:
        command, _ = controller.step(State(q=np.array(numbers[:7])), goal, stop)
    except GoalError:
        return
    assert command.is_finite()
    step = np.abs(model.velocities(command))
    assert (step <= model.acceleration_limits * 0.01 + 1e-12).all()


def test_a_qp_without_a_solution_brakes_and_reports_it(monkeypatch):
    controller = HolisticController(robot_model("frankie"))
    monkeypatch.setattr(Solver, "solve", lambda self, qp, rows: None)
    moving = Command(base_twist=np.array([0.9, 0.0, -0.8]), qd=np.full(7, 1.0))
    command, report = controller.step(State(), PoseGoal(target=tool_pose(2.0, 0.0, 0.7)), moving)
    assert not report.solved
    assert report.slack > 0.5  # of the braking
    model = controller.model
    step = model.velocities(moving) - model.velocities(command)
    np.testing.assert_allclose(np.abs(step), model.acceleration_limits * 0.01)
    assert (np.abs(model.velocities(command)) < np.abs(model.velocities(moving))).all()


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("joint", [0, 3, 5])
def test_a_start_outside_a_joint_limit_comes_back_slowly(robot, joint):
    limits = robot_model(robot).limits
    q = READY.copy()
    q[joint] = limits.q_max[joint] + 0.05
    run = run_to(None, robot=robot, state=State(q=q), seconds=2.0)
    path = np.array([state.q[joint] for state in run.states])
    outside = path > limits.q_max[joint]
    assert outside[0]
    assert not outside[-1]
    assert np.abs(np.diff(path)).max() <= 0.2 * 0.01 + 1e-9


FR3 = (
    (2.62, 0.30, 12.0, 2.75010),
    (2.62, 0.20, 5.17, 1.79180),
    (2.62, 0.20, 7.00, 2.90650),
    (2.62, 0.30, 8.00, -0.14580),
    (5.26, 0.35, 34.0, 2.81010),
    (4.18, 0.35, 11.0, 4.52050),
    (5.26, 0.35, 34.0, 3.01960),
)  # its maker allows min(a, sqrt(c (d - q)) - b) at a position q [rad/s]


@pytest.mark.parametrize("joint", range(7))
def test_an_fr3_is_no_faster_than_its_maker_allows_at_a_position(joint):
    model, (most, less, slope, end) = robot_model("frankie_fr3"), FR3[joint]
    bounds, number = VelocityBounds(model, ControllerSettings()), model.n_base + joint
    q, last, fastest = model.description.arm.ready.copy(), np.zeros(model.n), 0.0
    q[joint] = model.limits.q_min[joint] + 0.1
    for _ in range(500):
        last[number] = bounds.at(q, last)[1][number]
        fastest = max(fastest, last[number])
        assert last[number] <= min(most, max(np.sqrt(slope * (end - q[joint])) - less, 0.0)) + 1e-9
        q[joint] += 0.01 * last[number]
    assert fastest > 0.9 * most


@pytest.mark.parametrize("joint", [1, 3, 5])
@pytest.mark.parametrize("side", [0, 1])
def test_an_arm_that_lags_behind_its_commands_still_brakes_before_its_limits(joint, side):
    """As fast towards a limit as the bounds allow, by a robot that follows with a delay."""
    model = robot_model("frankie")
    bounds = VelocityBounds(model, ControllerSettings())
    q, qd, last = READY.copy(), np.zeros(7), np.zeros(model.n)
    q[joint] = (model.limits.q_max if side == 0 else model.limits.q_min)[joint]
    fastest = 0.0
    for _ in range(1500):
        last = np.array(bounds.at(q, last))[side]
        last[: model.n - 7] = 0.0
        last[model.n - 7 :][np.arange(7) != joint] = 0.0
        qd = qd + (1.0 - np.exp(-0.01 / 0.03)) * (last[model.n - 7 :] - qd)
        q = q + 0.01 * qd
        fastest = max(fastest, float(np.abs(qd).max()))
        assert model.limits.q_min[joint] <= q[joint] <= model.limits.q_max[joint]
    assert fastest > 1.0
    limit = (model.limits.q_min, model.limits.q_max)[side][joint]
    assert abs(q[joint] - limit) < 0.06


POSE = PoseGoal(target=tool_pose(1.0, 0.0, 0.7))


BASE = BaseGoal(target=SE3.Identity())


def refused(goal, message, state=None, last=None) -> None:
    with pytest.raises(GoalError, match=message):
        kept_controller("frankie").step(state or State(), goal, last or Command.stop(7))


@pytest.mark.parametrize(
    ("goal", "field", "value"),
    [
        (POSE, "speed", 0.0),
        (POSE, "turn_rate", np.nan),
        (POSE, "position_tolerance", -0.01),
        (PostureGoal(q=READY), "tolerance", np.nan),
        (BASE, "speed", -1.0),
        (BASE, "heading_tolerance", -0.01),
    ],
)
def test_a_goal_with_a_number_that_makes_no_sense_is_refused_by_name(goal, field, value):
    name = field.replace("_", " ")
    refused(replace(goal, **{field: value}), f"the goal's {name} must be a number")


def test_numbers_that_are_not_finite_and_too_few_joints_are_refused_by_name():
    refused(PoseGoal(target=tool_pose(np.nan, 0.0, 0.7)), "goal pose `target` must be .* numbers")
    refused(None, "joint positions `q` must be .* numbers", State(q=np.full(7, np.nan)))
    refused(PostureGoal(q=np.zeros(6)), r"the goal posture `q` must be an array \(7,\)")


@pytest.mark.parametrize("wrong", [READY.tolist(), np.zeros(5), np.zeros((7, 1)), None, "ready"])
def test_another_kind_or_size_of_array_is_refused_by_its_field(wrong):
    stop = Command.stop(7)
    refused(None, r"joint positions `q` must be an array \(7,\)", State(q=wrong))
    refused(PostureGoal(q=wrong), r"goal posture `q` must be an array \(7,\)")
    refused(None, "`qd` of the last command", last=replace(stop, qd=wrong))
    refused(None, r"`base_twist` of the last .* \(3,\)", last=replace(stop, base_twist=wrong))
    if wrong is not None:
        refused(replace(POSE, twist=wrong), r"goal's `twist` must be an array \(6,\)")


def test_a_matrix_is_no_pose_and_a_pose_no_goal():
    refused(PoseGoal(target=np.eye(4)), "`target` must be a pinocchio.SE3, got ndarray; SE3")
    refused(None, "base pose `mTb` must be a pinocchio.SE3, got ndarray", State(mTb=np.eye(4)))
    refused(SE3.Identity(), "goal must be one of PoseGoal, PostureGoal, BaseGoal.* got SE3")


@pytest.mark.parametrize(
    "rotation", [np.zeros((3, 3)), 1.01 * np.eye(3), np.diag([1.0, 1.0, -1.0]), np.eye(3) + 0.02]
)
def test_a_pose_without_a_rotation_is_refused(rotation):
    wrong = tool_pose(1.0, 0.0, 0.7)
    wrong.rotation = rotation
    refused(PoseGoal(target=wrong), "goal pose `target` must have a rotation matrix")
    refused(None, "base pose `mTb` must have a rotation matrix", State(mTb=wrong))


def test_settings_are_positive_numbers():
    with pytest.raises(ValueError, match="`period` of ControllerSettings must be a number above 0"):
        ControllerSettings(period=np.nan)
    with pytest.raises(ValueError, match="`smoothness` of ControllerSettings must be at least 0"):
        ControllerSettings(smoothness=-1.0)
    with pytest.raises(ValueError, match="`influence_distance` must be larger"):
        JointLimitSettings(influence_distance=0.03, stop_distance=0.03)


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
    goal = BaseGoal(target=base_pose(*target), reverse=True)
    run = run_to(goal, seconds=30.0, controller=HolisticController(model))
    assert run.arrived
    assert -SLOW <= slowest(run) < -0.1


def test_a_differential_drive_prefers_to_turn_where_backing_is_slow():
    """The same goal behind: with one speed it backs, with a slow reverse it turns around."""
    goal = PoseGoal(target=tool_pose(-2.4, 0.0, 0.6))
    slow = replace(FRANKIE, limits=replace(FRANKIE.limits, base_reverse=SLOW))
    backed, turned = (
        run_to(goal, controller=HolisticController(RobotModel(robot))) for robot in (FRANKIE, slow)
    )
    assert backed.arrived
    assert turned.arrived
    assert slowest(backed) < -0.9
    assert slowest(turned) > -SLOW
    assert len(turned.reports) * 0.01 < 8.0  # 2 m backwards alone would take 8 s
