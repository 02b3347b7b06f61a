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
    Cost,
    GoalError,
    HolisticController,
    KinematicState,
    PoseGoal,
    PostureGoal,
    Surroundings,
    robot_model,
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
        for terms in ((), (folded,))
    )
    assert own.arrived
    assert abs(own.state.q[-1]) < 0.5 * abs(without.state.q[-1])


def test_the_paper_has_no_more_terms_than_it_prints():
    """What is ours adds nothing with its settings."""
    goal, state = PoseGoal(target=tool_pose(2.0, 0.5, 0.6)), KinematicState(SE3.Identity(), READY)
    commands = [
        ROBOT.velocities(
            HolisticController(ROBOT, PAPER, standard_terms=terms).step(
                state, goal, Command.stop(7)
            )[0]
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
    controller = HolisticController(ROBOT, limits=(slow,))
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
    run = run_to(
        None,
        controller=HolisticController(ROBOT, limits=(onward,)),
        around=around,
        seconds=6.0,
        stays=True,
    )
    speeds = [command.base_twist[0] for command in run.commands]
    assert max(speeds) == pytest.approx(0.3, abs=1e-3)
    assert min(report.clearance for report in run.reports) > 0.005
    assert abs(speeds[-1]) < 0.02
    shortfalls = [report.shortfall for report in run.reports]
    assert shortfalls[0] == pytest.approx(0.3 - ROBOT.acceleration_limits[1] * 0.01)
    assert min(shortfalls) == pytest.approx(0.0, abs=1e-6)
    assert shortfalls[-1] == pytest.approx(0.3 - speeds[-1])  # the wall


def test_what_was_not_asked_to_go_stays():
    """A limit of somebody's own drops no other one, and a term no other one either."""
    controller = HolisticController(ROBOT, limits=(lambda constraints, now: None,))
    run = run_to(PoseGoal(target=tool_pose(1.5, 0.5, 0.6)), controller=controller)
    assert run.arrived
    with pytest.raises(ValueError, match="added to the standard ones"):
        HolisticController(ROBOT, terms=STANDARD_TERMS)


def test_standard_limits_go_by_an_explicit_word_and_velocity_limits_never():
    goal, state = PostureGoal(q=READY + 0.5), KinematicState(SE3.Identity(), READY)
    controller = HolisticController(ROBOT, standard_limits=False)
    command, _ = controller.step(state, goal, Command.stop(7))
    kept, _ = HolisticController(ROBOT).step(state, goal, Command.stop(7))
    assert command.qd.max() > 10.0 * kept.qd.max()
    assert (command.qd <= ROBOT.limits.qd).all()


NONE, ROW = np.full(N, np.nan), np.zeros((1, N))


@pytest.mark.parametrize(
    ("verb", "given", "wanted"),
    [
        ("track", (np.zeros(N), np.zeros(1), 1.0), rf"J of `track` must be an array \(m, {N}\)"),
        ("track", ([[0.0] * N], np.zeros(1), 1.0), "J of `track` must be an array"),
        ("track", (ROW, np.zeros(2), 1.0), r"twist of `track` must be an array \(1,\)"),
        ("track", (ROW + np.inf, np.zeros(1), 1.0), "J of `track`"),
        ("track", (ROW, np.zeros(1), -1.0), "weight of `track` must be a number from 0"),
        ("track", (ROW, np.zeros(1), np.ones(1)), "weight of `track` must be a number"),
        ("towards", (NONE, 1.0), "velocities of `towards`"),
        ("towards", (np.zeros(N), np.ones(3)), rf"weight of `towards` must be an array \({N},\)"),
        ("resist", (np.nan, 0.0), "weight of the base of `resist`"),
        ("resist", (0.0, "much"), "weight of the arm of `resist` must be a number .* 'much'"),
        ("reward", (np.zeros(N + 1),), rf"gradient of `reward` must be an array \({N},\)"),
    ],
)
def test_a_term_that_adds_no_numbers_is_refused_by_name_before_anything_moves(verb, given, wanted):
    def mine(cost, now, aim):
        getattr(cost, verb)(*given)

    with pytest.raises(GoalError, match=f"^term `mine`: .*{wanted}"):
        HolisticController(ROBOT, terms=(mine,))


@pytest.mark.parametrize(
    ("verb", "given", "wanted"),
    [
        ("narrow", (NONE, -NONE), r"lower bounds of `narrow` must be .* from -inf to inf"),
        ("narrow", (np.zeros(N), 1.0), "upper bounds of `narrow` must be an array"),
        ("narrow", (np.ones(N), -np.ones(N)), "must be lower <= upper"),
        ("keep", (np.zeros(N), np.zeros(N)), "A of `keep` must be an array"),
        ("keep", (ROW, np.array([np.nan])), "least of `keep`"),
        ("keep", (ROW, np.zeros(2)), r"least of `keep` must be an array \(1,\)"),
    ],
)
def test_a_limit_that_adds_no_numbers_is_refused_by_name(verb, given, wanted):
    class Mine:
        def __call__(self, constraints, now):
            getattr(constraints, verb)(*given)

    with pytest.raises(GoalError, match=f"^limit `Mine`: .*{wanted}"):
        HolisticController(ROBOT, limits=(Mine(),))


def test_a_term_that_fails_later_is_named_too():
    def late(cost, now, aim):
        cost.reward(np.full(N, np.nan if aim.error > 0.0 else 0.0))

    controller = HolisticController(ROBOT, terms=(late,))
    state, goal = KinematicState(SE3.Identity(), READY), PoseGoal(target=tool_pose(0.8, 0.0, 0.6))
    with pytest.raises(GoalError, match=r"^term `late`"):
        controller.step(state, goal, Command.stop(7))


def test_a_term_of_another_signature_fails_before_anything_moves():
    with pytest.raises(TypeError, match=r"takes 1 positional argument but 3"):
        HolisticController(ROBOT, terms=(lambda cost: None,))
