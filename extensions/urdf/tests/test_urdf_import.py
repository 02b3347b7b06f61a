"""Robot files from URDFs: a small mobile manipulator, foreign robots, and whatever is broken."""

import random
import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from command_line import call
from example_robots import EXAMPLES
from pinocchio import SE3
from scipy.spatial import ConvexHull

from config import UserError
from controller import HolisticController, PoseGoal, RobotModel, SelfCollision, bank
from extensions.urdf.hulls import hull_around
from extensions.urdf.importing import ImportOptions, write_robot
from lab.bench.motion_evaluation import Evaluator
from lab.bench.simulated_motion import run_motion
from robots import load_robot

URDF = (Path(__file__).parent / "small.urdf").read_text("utf-8")
"""A differential base with a lift, an arm of six joints and a gripper."""
JOINTS = ("pan", "shoulder", "elbow", "roll", "wrist", "turn")


def misses(robot, postures) -> list[object]:
    """What goes wrong on the way to the hand's poses in some postures, two metres away."""
    model, found = RobotModel(robot), []
    evaluator = Evaluator(model)
    for q in postures:
        oTe = SE3(pin.utils.rotate("z", 0.6), np.array([1.5, -1.3, 0.0])) * model.bTe(q)
        goal = PoseGoal(target=oTe)
        step = HolisticController(model).step
        trial = evaluator(run_motion(step, model, lambda _, g=goal: g, period=0.01, limit=20.0))
        if trial.failure or trial.limit_violations or trial.contact_samples:
            found.append((trial, np.round(q, 2)))
    return found


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robots")
    (folder / "small.urdf").write_text(URDF)
    out = folder / "small"
    return out, write_robot(folder / "small.urdf", out, ImportOptions())


def test_an_arm_of_every_kind_of_joint_is_that_of_its_urdf(small):
    out, notes = small
    robot = load_robot(out)
    assert robot.arm.slides.tolist() == [True, *[False] * 6]
    assert robot.limits.q_max[[0, 1]].tolist() == [0.3, np.inf]
    assert (robot.swivel.joint, robot.base.size) == (1, (0.6, 0.5, 0.3))
    assert robot.gripper.opening == pytest.approx(0.05)
    assert any("differential, by its 2 wheels" in note for note in notes)
    model, data = (whole := pin.buildModelFromXML(URDF)), whole.createData()
    ours, rng = RobotModel(robot), np.random.default_rng(0)
    for q in rng.uniform(*robot.limits.within_a_turn, (20, 7)):
        everything = pin.neutral(model)
        for joint, value in zip(("lift", *JOINTS), q, strict=True):
            one = model.joints[model.getJointId(joint)]
            unit = value if one.nq == 1 else (np.cos(value), np.sin(value))
            everything[one.idx_q : one.idx_q + one.nq] = unit
        pin.framesForwardKinematics(model, data, everything)
        tool = data.oMf[model.getFrameId("tool0")]
        bTe = ours.bTe(q)
        np.testing.assert_allclose(bTe.rotation[:, 2], tool.rotation[:, 2], atol=1e-9)
        np.testing.assert_allclose(bTe.translation, tool.act(np.array([0, 0, 0.06])), atol=1e-6)


def test_it_is_ready_with_its_hand_down_and_reaches_what_it_can(small):
    robot = load_robot(small[0])
    model, body = RobotModel(robot), SelfCollision(RobotModel(robot))
    assert model.bTe(robot.arm.ready).rotation[2, 2] < -0.999
    assert body.clearance(robot.arm.ready) > 0.01
    postures = bank(robot).q
    assert len(postures) > 2000
    assert min(body.clearance(q) for q in postures[::100]) > 0.0
    assert misses(robot, postures[::4000]) == []


def test_commands_import_check_and_refuse(small, tmp_path):
    file = small[0].parent / "small.urdf"
    mine, tool = tmp_path / "mine", tmp_path / "tool"
    assert call("robot", "import", file, "-o", mine, "--drive", "omni")[0] == 0
    code, output, _ = call("robot", "check", mine)
    assert (code, "7 joints" in output) == (0, True)
    assert "physical world: the URDF has no inertia" in output
    code, _, error = call("robot", "import", file, "-o", mine)
    assert (code, "exists already" in error) == (2, True)
    assert call("robot", "import", file, "-o", tool, "--tool-frame", "wrist_link")[0] == 0
    code, output, _ = call("check", "pick_place", "--robot", tool)
    assert (code, "`tool` has no gripper" in output) == (2, True)


BROKEN = (
    (URDF.replace('xyz="0 1 0"', 'xyz="0 0 0"'), "is zero"),
    (URDF.replace('link="tool0"', 'link="tool"'), "which is no link"),
    (URDF.replace('<child link="elbow_link"/>', '<child link="pan_link"/>'), "two parents"),
    (URDF.replace('name="elbow_link"', 'name="pan_link"'), "several links are called `pan_link`"),
    (URDF.replace("0.28", "280"), "millimetres"),
    (URDF.replace('lower="0" upper="0.3"', ""), "slides and has no range"),
    ("<robot/>", "no joint in it moves"),
    ("<sdf/>", "not <robot>"),
    ("what", "no XML"),
)


@pytest.mark.parametrize(("text", "why"), BROKEN, ids=[why for _, why in BROKEN])
def test_a_urdf_that_cannot_be_used_is_one_line(tmp_path, text, why):
    (tmp_path / "r.urdf").write_text(text)
    code, _, error = call("robot", "import", tmp_path / "r.urdf", "-o", tmp_path / "r")
    assert (code, why in error, error.strip().count("\n")) == (2, True, 0), error


def test_whatever_a_urdf_says_there_is_no_traceback(tmp_path):
    rng, text = random.Random(7), URDF
    words = sorted(set(re.findall(r'"[^"]*"', text)))
    tags = re.findall(r"<(?:link|joint)[^>]*>.*?</(?:link|joint)>", text, re.DOTALL)
    for number in range(100):
        mutant = text
        for _ in range(rng.randint(1, 3)):
            kind = rng.randrange(4)
            if kind == 0:
                some = rng.choice(['"nan"', '"-1 0"', '""', '"1e300"', '"0 0 0"', '"x"', '"-5"'])
                mutant = mutant.replace(rng.choice(words), some, rng.choice([1, -1]))
            elif kind == 1:
                mutant = mutant.replace(rng.choice(words), rng.choice(words), 1)
            elif kind == 2:
                mutant = mutant.replace(rng.choice(tags), rng.choice(["", rng.choice(tags)]), 1)
            else:
                at = rng.randrange(len(mutant))
                mutant = mutant[:at] + mutant[at + rng.randint(1, 20) :]
        path = tmp_path / f"{number}.urdf"
        path.write_text(mutant)
        with suppress(UserError):
            write_robot(path, tmp_path / str(number), ImportOptions(), lambda r: r.arm.ready)


FOREIGN = {
    "ur_description/urdf/ur5_gripper.urdf": (6, "franka_hand"),
    "panda_description/urdf/panda.urdf": (7, None),
    "tiago_description/robots/tiago_no_hand.urdf": (8, "franka_hand"),
}


@pytest.mark.skipif(not EXAMPLES.is_dir(), reason="example-robot-data is not installed")
@pytest.mark.parametrize("file", FOREIGN)
def test_foreign_robots_reach_goals_as_they_are(tmp_path, file):
    joints, gripper = FOREIGN[file]
    out = tmp_path / "robot"
    write_robot(EXAMPLES / file, out, ImportOptions(gripper=gripper))
    robot = load_robot(out)
    assert len(robot.arm.joints) == joints
    assert robot.gripper.grasps
    assert misses(robot, bank(robot).q[::6000]) == []
    body, q = SelfCollision(RobotModel(robot)), robot.arm.ready.copy()
    for turn in np.linspace(robot.limits.q_min[-1], robot.limits.q_max[-1], 20):
        q[-1] = turn
        assert body.clearance(q) > 0.02  # the hand turns freely


@pytest.mark.skipif(not EXAMPLES.is_dir(), reason="example-robot-data is not installed")
def test_a_robot_with_two_arms_and_many_shapes_is_ready_within_its_limits(tmp_path):
    file, out = EXAMPLES / "tiago_description/robots/tiago_dual.urdf", tmp_path / "dual"
    write_robot(file, out, ImportOptions())
    robot = load_robot(out)
    q, limits = robot.arm.ready, robot.limits
    assert (np.minimum(q - limits.q_min, limits.q_max - q) > 0.01).all()


def test_a_hull_holds_all_points_with_few_corners():
    ball = np.random.default_rng(0).normal(size=(5000, 3))
    ball *= 0.1 / np.linalg.norm(ball, axis=1, keepdims=True)
    for points in (ball, ball * [1.0, 1.0, 0.0], ball[:40] + 1.0):
        one = hull_around(points)
        assert len(one.shape.vertices) < 400
        corners = np.round(one.shape.vertices + one.pose.translation, 6)  # as in the file
        planes = ConvexHull(corners).equations
        assert (points @ planes[:, :3].T + planes[:, 3]).max() < 1e-9
        assert np.ptp(corners, axis=0).max() < 0.21
