"""The simulated robot does what its equations say, and nothing without a command."""

import numpy as np
import pinocchio as pin
import pytest
from harness import TABLE_TOP, block, looking_down, table_world
from pinocchio import SE3

from controller import Command, robot_model
from hw import SimClock
from hw.sim.robot import CAMERA, TOOL_TO_CAMERA, Dynamics, SimRobot
from robots import load_robot

READY = load_robot("frankie").arm.ready


def make(*objects, robot: str = "frankie", **options) -> tuple[SimRobot, SimClock]:
    clock = SimClock()
    return SimRobot(robot_model(robot), table_world(*objects), clock, **options), clock


def drive(robot: SimRobot, clock: SimClock, command: Command, seconds: float) -> None:
    for _ in range(round(seconds * 100)):
        robot.send(command)
        clock.sleep_until(clock.now() + 0.01)
    robot.read()


def test_velocities_follow_commands_with_their_lag():
    robot, clock = make()
    command = Command(base_twist=np.array([0.5, 0.0, 0.2]), qd=np.full(7, 0.1))
    drive(robot, clock, command, 0.1)
    state = robot.read()
    reached = 1.0 - np.exp(-0.1 / Dynamics().base_lag)
    np.testing.assert_allclose(state.base_twist, reached * command.base_twist, rtol=1e-9)
    reached = 1.0 - np.exp(-0.1 / Dynamics().arm_lag)
    np.testing.assert_allclose(state.qd, reached * command.qd, rtol=1e-9)


def test_a_constant_twist_drives_a_circle():
    robot, clock = make(dynamics=Dynamics(base_lag=1e-6))
    v, w = 0.4, 0.8
    drive(robot, clock, Command(base_twist=np.array([v, 0.0, w]), qd=np.zeros(7)), 2.0)
    state = robot.read()
    angle, radius = w * 2.0, v / w
    expected = [radius * np.sin(angle), radius * (1.0 - np.cos(angle)), 0.0]
    np.testing.assert_allclose(state.wTb.translation, expected, atol=1e-9)


def test_the_omni_base_goes_sideways():
    robot, clock = make(robot="omni", dynamics=Dynamics(base_lag=1e-6))
    drive(robot, clock, Command(base_twist=np.array([0.0, 0.3, 0.0]), qd=np.zeros(7)), 1.0)
    np.testing.assert_allclose(robot.read().wTb.translation, [0.0, 0.3, 0.0], atol=1e-9)


def test_a_missing_command_is_a_stop():
    robot, clock = make()
    drive(robot, clock, Command(base_twist=np.array([0.5, 0.0, 0.0]), qd=np.full(7, 0.2)), 0.5)
    clock.sleep_until(clock.now() + 2.0)
    state = robot.read()
    assert np.abs(state.base_twist).max() < 1e-6
    assert np.abs(state.qd).max() < 1e-6


def test_a_reading_is_not_changed_by_what_comes_later():
    robot, clock = make()
    before = robot.read()
    q, x = before.q.copy(), before.wTb.translation.copy()
    drive(robot, clock, Command(base_twist=np.array([0.5, 0.0, 0.0]), qd=np.full(7, 0.2)), 0.5)
    np.testing.assert_array_equal(before.q, q)
    np.testing.assert_array_equal(before.wTb.translation, x)


def test_the_camera_looks_at_what_is_below_the_hand():
    robot, _ = make(block())
    frame = robot.depth()
    assert frame.depth.shape == (CAMERA.height, CAMERA.width)
    wTe = robot_model("frankie").wTe(SE3.Identity(), READY)
    assert frame.wTc.isApprox(wTe * TOOL_TO_CAMERA, 1e-12)
    top = np.array([0.7, 0.0, TABLE_TOP + 0.05])  # of the block
    x, y, z = frame.wTc.actInv(top)
    u, v = CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy
    seen = frame.depth[round(v) - 3 : round(v) + 4, round(u) - 3 : round(u) + 4]
    assert np.nanmedian(seen) == pytest.approx(z, abs=0.005)


def test_a_frame_is_given_once_and_comes_thirty_times_a_second():
    robot, clock = make()
    frames = 0
    for _ in range(100):
        frames += robot.depth() is not None
        clock.sleep_until(clock.now() + 0.01)
    assert frames == 30
    assert robot.depth() is not None
    assert robot.depth() is None


def test_frames_depend_on_seed_and_time_only():
    pictures = []
    for skipped in (True, False):
        robot, clock = make(block(), seed=3)
        for _ in range(20):
            if not skipped:
                robot.depth()
            clock.sleep_until(clock.now() + 0.05)
        pictures.append(robot.depth().depth)
    np.testing.assert_array_equal(*pictures)
    other, clock = make(block(), seed=4)
    clock.sleep_until(1.0)
    assert not np.array_equal(other.depth().depth, pictures[0], equal_nan=True)


def at_block(robot: SimRobot) -> SimRobot:
    """Put the hand around the block, by the arm's own kinematics."""
    model = robot_model("frankie")
    target = looking_down(0.7, 0.0, TABLE_TOP + 0.03, yaw=np.pi / 2)
    q = READY.copy()
    for _ in range(200):
        bTe, J, *_ = model.kinematics(q)
        J = J[:, model.n_base :]
        error = np.concatenate([target.translation - bTe.translation, rotation_error(bTe, target)])
        q = q + np.linalg.pinv(J, rcond=1e-3) @ error * 0.3
    robot._q = q  # the arm is simply there: the way is not what is tested
    return robot


def rotation_error(here: SE3, there: SE3) -> np.ndarray:
    return here.rotation @ pin.log3(here.rotation.T @ there.rotation)


def rise(robot: SimRobot, clock: SimClock) -> None:
    """The hand straight up at 0.2 m/s, for a second."""
    model = robot_model("frankie")
    for _ in range(100):
        _, J, *_ = model.kinematics(robot.read().q)
        qd = np.linalg.pinv(J[:, model.n_base :]) @ np.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0])
        robot.send(Command(base_twist=np.zeros(3), qd=qd))
        clock.sleep_until(clock.now() + 0.01)


def test_fingers_close_on_what_is_between_them_and_carry_it():
    robot, clock = make(block())
    at_block(robot).grip(0.0, 20.0)
    assert robot.read().gripper_moving
    clock.sleep_until(1.0)
    state = robot.read()
    assert not state.gripper_moving
    assert state.gripper_width == pytest.approx(0.04, abs=0.001)
    height = robot.world.find("block").pose.translation[2]
    up = np.zeros(7)
    up[1] = -0.3
    drive(robot, clock, Command(base_twist=np.zeros(3), qd=up), 0.5)
    assert robot.world.find("block").pose.translation[2] > height + 0.03
    robot.grip(0.08, 20.0)
    assert robot.world.find("block").pose.translation[2] == pytest.approx(height, abs=5e-3)


def test_fingers_that_stop_before_the_object_do_not_take_it():
    robot, clock = make(block())
    at_block(robot).grip(0.06, 20.0)
    clock.sleep_until(1.0)
    assert robot.read().gripper_width == pytest.approx(0.06)
    assert robot.world.held is None


def test_fingers_that_press_on_what_they_cannot_hold_stop_and_slip_off_when_the_hand_rises():
    robot, clock = make(block(mass=20.0))
    at_block(robot).grip(0.0, 20.0)
    clock.sleep_until(1.0)
    state = robot.read()
    assert robot.world.held is None
    assert not state.gripper_moving
    assert state.gripper_width == pytest.approx(0.04, abs=0.001)
    rise(robot, clock)
    state = robot.read()
    assert state.gripper_width == 0.0
    assert not state.gripper_moving
    assert state.faults == ()


def test_running_into_something_trips_the_reflex_until_it_is_cleared():
    robot, clock = make(block(half=(0.02, 0.03, 0.08)))
    at_block(robot)
    robot._q = robot._q + np.array([0.1, 0, 0, 0, 0, 0, 0])
    robot._integrate(Command.stop(), 0.01)
    state = robot.read()
    assert [fault.kind.value for fault in state.faults] == ["reflex"]
    assert state.faults[0].text == "the hand hit block"
    assert state.faults[0].clearable
    before = state.q
    applied = robot.send(Command(base_twist=np.zeros(3), qd=np.full(7, 0.2)))
    assert not applied.qd.any()
    clock.sleep_until(clock.now() + 0.1)
    np.testing.assert_array_equal(robot.read().q, before)
    robot.recover()
    assert robot.read().faults == ()
    up = np.zeros(7)
    up[1] = -0.3
    drive(robot, clock, Command(base_twist=np.zeros(3), qd=up), 0.5)
    assert robot.read().faults == ()  # moving off what was hit is allowed
