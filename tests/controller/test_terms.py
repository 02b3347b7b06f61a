"""Terms and limits of somebody else's package, and the sums that they make."""

import numpy as np
import pytest
from motion import READY, run_to, tool_pose
from pinocchio import SE3

from controller import (
    PAPER,
    PAPER_TERMS,
    STANDARD_TERMS,
    Command,
    ControllerSettings,
    Cost,
    HolisticController,
    KinematicState,
    PoseGoal,
    PostureGoal,
    Surroundings,
    robot_model,
    standard_limits,
)
from robots import Box, Geom

ROBOT = robot_model("frankie")
N, LAST = ROBOT.n, ROBOT.n - 1


def test_a_cost_is_the_sum_of_what_its_verbs_say():
    rng, cost = np.random.default_rng(0), Cost(ROBOT)
    rows = [(rng.normal(size=(m, N)), rng.normal(size=m), rng.uniform()) for m in (6, 1)]
    wanted = [(rng.normal(size=N), w) for w in (0.7, rng.uniform(size=N))]
    gradient = rng.normal(size=N)
    for J, twist, weight in rows:
        cost.track(J, twist, weight)
    for velocities, weight in wanted:
        cost.towards(velocities, weight)
    cost.reward(gradient)
    cost.resist(0.3, 0.2)
    qp = cost.qp(*ROBOT.velocity_limits)

    def value(x):
        tracked = sum(w * np.sum((J @ x - v) ** 2) for J, v, w in rows)
        near = sum(np.sum(w * (x - v) ** 2) for v, w in wanted)
        still = 0.3 * np.sum(x[: ROBOT.n_base] ** 2) + 0.2 * np.sum(x[ROBOT.n_base :] ** 2)
        return 0.5 * (tracked + near + still) - gradient @ x

    for x in rng.normal(size=(5, N)):
        assert 0.5 * x @ qp.P @ x + qp.c @ x == pytest.approx(value(x) - value(np.zeros(N)))


def folded(cost, now, aim):
    """½ w |q̇ - v|²: the last joint turns to zero."""
    wanted = np.zeros(N)
    wanted[LAST] = -2.0 * now.state.q[-1]
    cost.towards(wanted, 30.0 * (np.arange(N) == LAST))


def test_a_term_of_ones_own_changes_a_motion_and_the_goal_is_still_reached():
    goal = PoseGoal(target=tool_pose(0.75, 0.0, 0.6, yaw=0.3), orientation_tolerance=np.pi)
    without, own = (
        run_to(goal, controller=HolisticController(ROBOT, terms=terms), seconds=6.0, stays=True)
        for terms in (STANDARD_TERMS, (*STANDARD_TERMS, folded))
    )
    assert own.arrived
    assert abs(own.state.q[-1]) < 0.5 * abs(without.state.q[-1])


def test_the_paper_has_no_more_terms_than_it_prints():
    """What is ours adds nothing with its settings."""
    goal, state = PoseGoal(target=tool_pose(2.0, 0.5, 0.6)), KinematicState(SE3.Identity(), READY)
    commands = [
        ROBOT.velocities(
            HolisticController(ROBOT, PAPER, terms=terms).step(state, goal, Command.stop(7))[0]
        )
        for terms in (PAPER_TERMS, STANDARD_TERMS)
    ]
    np.testing.assert_array_equal(*commands)


def slow(constraints, now):
    """The last joint at 0.1 rad/s, in whatever acceleration allows."""
    speed = np.full(N, np.inf)
    speed[LAST] = 0.1
    constraints.narrow(-speed, speed)


def test_bounds_of_ones_own_hold_for_every_goal_and_leave_accelerations_alone():
    limits = (*standard_limits(ROBOT, ControllerSettings()), slow)
    controller = HolisticController(ROBOT, limits=limits)
    fast = ROBOT.command(np.eye(N)[LAST] * 1.5)
    run = run_to(PostureGoal(q=READY + 0.4), controller=controller, last=fast)  # within all limits
    assert run.arrived
    speeds = np.abs([command.qd[-1] for command in run.commands])
    assert speeds[-1] <= 0.1
    assert (np.diff(speeds) <= 1e-12).all()  # it brakes, and is slow from then on


def test_rows_of_ones_own_are_kept_and_give_way_to_obstacles():
    """Somebody wants the base to drive on, and there is a wall."""

    def onward(constraints, now):
        constraints.keep(np.eye(N)[[1]] if ROBOT.turning == 0 else np.eye(N)[[0]], np.array([0.3]))

    wall = Geom(Box((0.1, 2.0, 1.0)), SE3(np.eye(3), np.array([1.6, 0.0, 1.0])), "wall")
    around = Surroundings(fixtures=(wall,))
    limits = (*standard_limits(ROBOT, ControllerSettings()), onward)
    run = run_to(
        None,
        controller=HolisticController(ROBOT, limits=limits),
        around=around,
        seconds=6.0,
        stays=True,
    )
    speeds = [command.base_twist[0] for command in run.commands]
    assert max(speeds) == pytest.approx(0.3, abs=1e-3)
    assert min(report.clearance for report in run.reports) > 0.005
    assert abs(speeds[-1]) < 0.02
