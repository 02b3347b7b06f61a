"""Nothing is hit: the robot among things that stand and move, judged by geometry of its own."""

import numpy as np
import pinocchio as pin
import pytest
from motion import READY, Run, State, run_to, tool_pose
from pinocchio import SE3
from test_floor_map import distance

from controller import (
    BaseGoal,
    ControllerSettings,
    HolisticController,
    PointCloud,
    PoseGoal,
    PostureGoal,
    Surroundings,
    robot_model,
)
from robots import Box, Cylinder, Geom

WALL = Geom(Box((0.05, 3.0, 0.15)), SE3(np.eye(3), np.array([2.0, 0.0, 0.15])), "wall")
"""Too low for the arm to meet it."""
TABLE_TOP = Geom(Box((0.5, 0.5, 0.015)), SE3(np.eye(3), np.array([1.0, 0.0, 0.3])), "table/top")


def corners(model, mTb) -> np.ndarray:
    length, width, _ = model.description.base.size
    ends = [(x, y, 0.1) for x in (-length / 2, length / 2) for y in (-width / 2, width / 2)]
    return np.array([mTb.act(np.array(end)) for end in ends])


@pytest.fixture
def model():
    return robot_model("frankie")


UNGUIDED = ControllerSettings(guidance=False)
"""Guidance would lead the base around."""


def drive(model, goal, surroundings, seconds, start=None, settings=None) -> Run:
    """A robot that follows late, for all of the time."""
    return run_to(
        goal,
        state=State(mTb=start or SE3.Identity()),
        seconds=seconds,
        controller=HolisticController(model, settings),
        around=surroundings,
        late=True,
        stays=True,
    )


def hands(model, run) -> np.ndarray:
    """(N, 3) places of the hand on its way."""
    return np.array([model.end_effector(state.mTb, state.q).translation for state in run.states])


@pytest.mark.parametrize(("speed", "heading"), [(0.3, 0.0), (1.5, 0.6)])
def test_a_base_that_is_sent_through_a_wall_stops_before_it(model, speed, heading):
    start = SE3(pin.utils.rotate("z", heading), np.zeros(3))
    goal = PoseGoal(target=tool_pose(4.0, 0.0, 0.7), speed=speed)
    run = drive(model, goal, Surroundings(fixtures=(WALL,)), 8.0, start, UNGUIDED)
    nearest = min(1.95 - corners(model, state.mTb)[:, 0].max() for state in run.states)
    assert 0.005 < nearest < 0.2
    assert run.reports[-1].nearest.endswith("and wall")
    assert run.reports[-1].clearance < 0.3


def test_a_base_goal_behind_a_wall_is_reached_around_it(model):
    goal = BaseGoal(target=SE3(np.eye(3), np.array([4.0, 0.0, 0.0])))
    run = drive(model, goal, Surroundings(fixtures=(WALL,)), 25.0)
    for state in run.states:
        beyond = np.abs(corners(model, state.mTb)[:, :2] - [2.0, 0.0]) - [0.05, 3.0]
        assert np.hypot(*np.maximum(beyond, 0.0).T).min() > 0.005
    assert run.arrived


def test_a_base_goal_inside_furniture_is_refused_at_once_and_the_base_stands_still(model):
    goal = BaseGoal(target=SE3(np.eye(3), np.array([2.0, 0.5, 0.3])))
    run = drive(model, goal, Surroundings(fixtures=(WALL,)), 0.5)
    assert run.reports[0].unreachable == "the base would stand in wall"
    assert np.abs(run.state.mTb.translation).max() < 1e-6


def lowest(model, height: float, may: bool = False, **around) -> float:
    """How low a hand comes that is sent straight down on a table [m]."""
    goal = PoseGoal(target=tool_pose(1.0, 0.0, height), straight=True, hand_may_touch=may)
    run = drive(model, goal, Surroundings(fixtures=(TABLE_TOP,), **around), 5.0)
    return float(hands(model, run)[:, 2].min())


def test_the_hand_stops_above_a_table_and_goes_down_to_it_when_it_may(model):
    """The finger capsule ends 17 mm below the tool centre."""
    assert lowest(model, 0.32) > 0.315 + 0.0166 + 0.003
    assert lowest(model, 0.32, may=True) == pytest.approx(0.32, abs=2e-3)


def test_what_is_held_keeps_off_too(model):
    rod = Geom(Box((0.02, 0.02, 0.15)), SE3(np.eye(3), np.array([0.0, 0.0, 0.12])), "held")
    assert lowest(model, 0.36) == pytest.approx(0.36, abs=2e-3)
    assert lowest(model, 0.36, held=(rod,)) > 0.315 + 0.27


def test_an_arm_that_folds_keeps_off_what_is_in_its_way(model):
    """A post beside the arm; the straight way of the joints sweeps through it."""
    x, y = model.description.bTa.translation[:2]
    post = Geom(Cylinder(0.05, 1.0), SE3(np.eye(3), np.array([x + 0.1, y + 0.45, 1.0])), "post")
    goal, gaps = PostureGoal(q=np.array([2.5, *READY[1:]])), []
    for around in (Surroundings(), Surroundings(fixtures=(post,)), Surroundings(loose=(post,))):
        away = hands(model, drive(model, goal, around, 6.0)) - post.pose.translation
        gaps.append(np.hypot(away[:, 0], away[:, 1]).min())
    assert gaps[0] < 0.13  # it would hit the post
    assert min(gaps[1:]) > gaps[0] + 0.02


@pytest.mark.parametrize("aside", [0.0005, 0.05])
def test_the_palm_comes_to_a_wall_and_does_not_touch_it_where_the_hand_may(model, aside):
    """A grasp beside a wall as high as the palm, which it would clear by 1 mm less `aside`."""
    palm = model.description.gripper.palm
    half = palm.shape.half
    mTe = tool_pose(0.65, 0.0, 0.55)
    beside = mTe.translation[1] + mTe.rotation[1] @ palm.pose.translation
    reach = half[0] if abs(mTe.rotation[1, 0]) > 0.5 else half[1]
    face = beside + reach + 0.001 - aside
    wall = Geom(
        Box((0.3, 0.005, 0.05)), SE3(np.eye(3), np.array([0.65, face + 0.005, 0.62])), "wall"
    )
    goal = PoseGoal(target=mTe, straight=True, hand_may_touch=True)
    run = drive(model, goal, Surroundings(fixtures=(wall,)), 4.0)
    for state in run.states:
        mTp = model.end_effector(state.mTb, state.q) * palm.pose
        assert distance(Geom(palm.shape, mTp), wall) > 0.0
    assert aside > 0.001 or np.linalg.norm(hands(model, run)[-1] - mTe.translation) < 0.004


def test_a_base_that_turns_before_a_walls_end_keeps_its_face_off_it(model):
    """Nearest is a corner of the base, which the turn takes away; then it is the wall's end."""
    wall = Geom(Box((0.05, 1.0, 0.15)), SE3(np.eye(3), np.array([1.0, 1.0, 0.15])), "wall")
    start = SE3(pin.utils.rotate("z", -0.3), np.zeros(3))
    goal = PoseGoal(target=tool_pose(1.6, 1.2, 0.7), straight=True)
    middle = SE3(np.eye(3), np.array([0, 0, 0.19]))
    for state in drive(model, goal, Surroundings(fixtures=(wall,)), 4.0, start, UNGUIDED).states:
        assert distance(Geom(Box((0.35, 0.25, 0.19)), state.mTb * middle), wall) > 0.005


def gap_to_the_wall(model, uncertainty: float, *, is_seen: bool = False) -> float:
    """Where a base that is sent through the wall, or what a camera sees of it, stops."""
    y, z = np.meshgrid(np.arange(-0.8, 0.8, 0.02), np.arange(0.05, 1.0, 0.05))
    cloud = PointCloud(np.stack([np.full(y.size, 1.95), y.ravel(), z.ravel()], axis=1))
    known = {"depth_points": cloud} if is_seen else {"fixtures": (WALL,)}
    goal = PoseGoal(target=tool_pose(4.0, 0.0, 0.7), speed=0.5)
    around = Surroundings(**known, uncertainty=uncertainty)
    start = SE3(np.eye(3), np.array([1.0, 0.0, 0.0]))
    run = drive(model, goal, around, 2.5, start, UNGUIDED)
    return 1.95 - float(corners(model, run.state.mTb)[:, 0].max())


def test_a_robot_that_is_unsure_of_its_place_stops_farther_from_the_map_but_not_from_what_it_sees(
    model,
):
    sure = gap_to_the_wall(model, 0.0)
    assert gap_to_the_wall(model, 0.03) == pytest.approx(sure + 0.03, abs=0.008)
    assert gap_to_the_wall(model, 0.2) == pytest.approx(sure + 0.05, abs=0.008)
    seen = gap_to_the_wall(model, 0.0, is_seen=True)
    assert gap_to_the_wall(model, 0.03, is_seen=True) == pytest.approx(seen, abs=0.002)


def test_a_robot_within_its_margin_does_not_give_way_and_its_hand_works_as_ever(model):
    goal = PoseGoal(target=tool_pose(1.0, 0.0, 0.32), straight=True)
    sure, unsure = (
        drive(model, goal, Surroundings(fixtures=(TABLE_TOP,), uncertainty=uncertainty), 3.0)
        for uncertainty in (0.0, 0.05)
    )
    np.testing.assert_allclose(hands(model, sure)[-1], hands(model, unsure)[-1], atol=0.004)


def test_a_base_that_may_be_far_off_drives_half_as_fast(model):
    goal, fastest = BaseGoal(target=SE3(np.eye(3), np.array([4.0, 0.0, 0.0]))), []
    for uncertainty in (0.0, 0.08):
        run = drive(model, goal, Surroundings(uncertainty=uncertainty), 4.0)
        fastest.append(np.diff([state.mTb.translation[0] for state in run.states]).max())
    assert fastest[1] == pytest.approx(0.5 * fastest[0], rel=0.05)
