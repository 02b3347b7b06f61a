"""Goals that move are followed, whether their velocity is known or not; noise is not."""

import numpy as np
import pinocchio as pin
import pytest
from motion import State, move, run_to, tool_pose
from pinocchio import SE3

from controller import Command, HolisticController, PoseGoal, robot_model
from controller.servo import GoalVelocity

PERIOD = 0.01


def estimated(positions) -> list[np.ndarray]:
    """The twist that a goal seems to have, after each of its positions."""
    motion, twists = GoalVelocity(PERIOD), []
    for position in positions:
        goal = motion(PoseGoal(target=tool_pose(*position)))
        twists.append(np.zeros(6) if goal.twist is None else goal.twist)
    return twists


def test_the_velocity_of_a_goal_is_found_within_a_second_and_jumps_and_tremors_are_none():
    velocity = np.array([0.2, -0.3, 0.05])
    twist = estimated(velocity * PERIOD * k for k in range(100))[-1]
    np.testing.assert_allclose(twist, [*velocity, 0.0, 0.0, 0.0], atol=1e-3)
    jumping = [(0.0, 0.0, 0.5)] * 50 + [(0.3, 0.0, 0.5)] * 50
    trembling = np.random.default_rng(0).normal(size=(500, 3)) * 0.002
    for positions in (jumping, trembling):
        assert not np.any(estimated(positions))


def line(time: float) -> tuple[SE3, np.ndarray]:
    return tool_pose(2.0, -1.5 + 0.3 * time, 0.7), np.array([0.0, 0.3, 0.0, 0.0, 0.0, 0.0])


def circle(time: float) -> tuple[SE3, np.ndarray]:
    """Of 1 m, the tool turning with the path."""
    angle = 0.3 * time
    place = (1.0 + np.cos(angle), 0.5 + np.sin(angle), 0.7)
    velocity = 0.3 * np.array([-np.sin(angle), np.cos(angle)])
    return tool_pose(*place, yaw=angle), np.array([*velocity, 0.0, 0.0, 0.0, 0.3])


def errors(run, begin: int) -> tuple[float, float]:
    """The largest of position and orientation from a period on."""
    told = run.reports[begin:]
    return max(one.position_error for one in told), max(one.orientation_error for one in told)


@pytest.mark.parametrize(
    ("robot", "path", "known", "allowed"),
    [("frankie", circle, False, 0.04), ("omni", line, True, 0.01)],
)
def test_a_moving_goal_is_followed(robot, path, known, allowed):

    def goal(time):
        mTe, twist = path(time)
        return PoseGoal(target=mTe, twist=twist if known else None)

    position, orientation = errors(run_to(goal, robot=robot, seconds=14.0, stays=True), 900)
    assert position < allowed
    assert orientation < np.deg2rad(5.0)


def test_a_differential_drive_is_not_wound_up_by_a_tool_that_keeps_its_yaw():
    """Around a circle of 0.6 m: a base that follows the path would wind up the arm."""

    def goal(time):
        angle = 0.5 * time
        place = (1.0 + 0.6 * np.sin(angle), 0.6 * (1.0 - np.cos(angle)), 0.7)
        twist = np.array([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.0, 0.0, 0.0, 0.0])
        return PoseGoal(target=tool_pose(*place), twist=twist)

    position, orientation = errors(run_to(goal, seconds=17.0, stays=True), 800)
    assert position < 0.01
    assert orientation < np.deg2rad(2.0)


def test_noise_of_the_state_does_not_shake_a_robot_at_its_goal():
    """1 mrad, 5 mm and 0.3 degrees: a robot that follows them moves its base at 18 mm/s."""
    model, rng = robot_model("frankie"), np.random.default_rng(0)
    controller = HolisticController(model)
    state, last = State(), Command.stop(7)
    goal = PoseGoal(target=tool_pose(1.5, 0.8, 0.6, yaw=0.6))
    speeds, joints, errors = [], [], []
    for k in range(1400):
        x, y = rng.normal(size=2) * 0.005
        turn = pin.utils.rotate("z", rng.normal() * np.deg2rad(0.3))
        translation = state.mTb.translation + np.array([x, y, 0.0])
        seen = State(
            SE3(turn @ state.mTb.rotation, translation), state.q + rng.normal(size=7) / 1e3
        )
        last, _ = controller.step(seen, goal, last)
        move(state, last)
        if k >= 800:
            speeds.append(np.linalg.norm(last.base_twist[:2]))
            joints.append(np.abs(last.qd).max())
            tool = model.end_effector(state.mTb, state.q)
            errors.append(np.linalg.norm(tool.translation - goal.target.translation))
    assert np.sqrt(np.mean(np.square(speeds))) < 0.008
    assert max(joints) < 0.06
    assert max(errors) < 0.006
