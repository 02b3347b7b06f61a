"""The simulated robot does what its equations say, and nothing without a command."""

from dataclasses import replace
from math import inf

import numpy as np
import pinocchio as pin
import pytest
from harness import TABLE_TOP, block, looking_down, open_floor, table_world
from pinocchio import SE3

from controller import Command, robot_model
from hw import ComposedRobot, SimClock
from hw.sim import kinematic_robot
from robots import load_robot

FRANKIE = load_robot("frankie")


class Sim:
    """A simulated robot with its world and clock in hand."""

    def __init__(self, *objects, robot: str = "frankie", lag: float | None = None, **options):
        self.clock = SimClock()
        self.world = table_world(*objects) if objects else open_floor()
        described = load_robot(robot)
        if lag is not None:
            described = replace(described, base=replace(described.base, lag=lag))
        self.robot = kinematic_robot(described, self.world, self.clock, **options)
        self.body = self.robot._arm._body  # what no robot tells: the way is not what is tested

    def drive(self, command: Command, seconds: float) -> None:
        for _ in range(round(seconds * 100)):
            self.robot.send(command)
            self.clock.sleep_until(self.clock.now() + 0.01)
        self.robot.read()


def test_velocities_follow_commands_with_their_lag():
    sim = Sim()
    command = Command(base_twist=np.array([0.5, 0.0, 0.2]), qd=np.full(7, 0.1))
    sim.drive(command, 0.1)
    state = sim.robot.read()
    reached = 1.0 - np.exp(-0.1 / FRANKIE.base.lag)
    np.testing.assert_allclose(state.base_twist, reached * command.base_twist, rtol=1e-9)
    reached = 1.0 - np.exp(-0.1 / FRANKIE.arm.lag)
    np.testing.assert_allclose(state.qd, reached * command.qd, rtol=1e-9)


def test_a_constant_twist_drives_a_circle():
    sim = Sim(lag=1e-6)
    v, w = 0.4, 0.8
    sim.drive(Command(base_twist=np.array([v, 0.0, w]), qd=np.zeros(7)), 2.0)
    state = sim.robot.read()
    angle, radius = w * 2.0, v / w
    expected = [radius * np.sin(angle), radius * (1.0 - np.cos(angle)), 0.0]
    np.testing.assert_allclose(state.wTb.translation, expected, atol=1e-9)


def test_the_omni_base_goes_sideways():
    sim = Sim(robot="omni", lag=1e-6)
    sim.drive(Command(base_twist=np.array([0.0, 0.3, 0.0]), qd=np.zeros(7)), 1.0)
    np.testing.assert_allclose(sim.robot.read().wTb.translation, [0.0, 0.3, 0.0], atol=1e-9)


def test_a_missing_command_is_a_stop():
    sim = Sim()
    sim.drive(Command(base_twist=np.array([0.5, 0.0, 0.0]), qd=np.full(7, 0.2)), 0.5)
    sim.clock.sleep_until(sim.clock.now() + 2.0)
    state = sim.robot.read()
    assert np.abs(state.base_twist).max() < 1e-6
    assert np.abs(state.qd).max() < 1e-6


def test_a_reading_is_not_changed_by_what_comes_later():
    sim = Sim()
    before = sim.robot.read()
    q, x = before.q.copy(), before.wTb.translation.copy()
    sim.drive(Command(base_twist=np.array([0.5, 0.0, 0.0]), qd=np.full(7, 0.2)), 0.5)
    np.testing.assert_array_equal(before.q, q)
    np.testing.assert_array_equal(before.wTb.translation, x)


def test_the_camera_looks_at_what_is_below_the_hand():
    sim = Sim(block())
    frame = sim.robot.camera.latest(inf)
    assert frame.depth.shape == (FRANKIE.camera.intrinsics.height, FRANKIE.camera.intrinsics.width)
    wTe = robot_model("frankie").wTe(SE3.Identity(), FRANKIE.arm.ready)
    assert frame.wTc.isApprox(wTe * FRANKIE.camera.eTc, 1e-12)
    top = np.array([0.7, 0.0, TABLE_TOP + 0.05])  # of the block
    x, y, z = frame.wTc.actInv(top)
    u, v = (
        FRANKIE.camera.intrinsics.fx * x / z + FRANKIE.camera.intrinsics.cx,
        FRANKIE.camera.intrinsics.fy * y / z + FRANKIE.camera.intrinsics.cy,
    )
    seen = frame.depth[round(v) - 3 : round(v) + 4, round(u) - 3 : round(u) + 4]
    assert np.nanmedian(seen) == pytest.approx(z, abs=0.005)


def test_a_new_frame_comes_thirty_times_a_second():
    sim = Sim()
    frames = []
    for _ in range(100):
        frames.append(sim.robot.camera.latest(inf))
        sim.clock.sleep_until(sim.clock.now() + 0.01)
    assert len({id(frame) for frame in frames}) == 30
    assert frames[0] is frames[1]
    assert frames[0].stamp == 0.0


def test_frames_depend_on_seed_and_time_only():
    pictures = []
    for skipped in (True, False):
        sim = Sim(block(), seed=3)
        for _ in range(20):
            if not skipped:
                sim.robot.camera.latest(inf)
            sim.clock.sleep_until(sim.clock.now() + 0.05)
        pictures.append(sim.robot.camera.latest(inf).depth)
    np.testing.assert_array_equal(*pictures)
    other = Sim(block(), seed=4)
    other.clock.sleep_until(1.0)
    depth = other.robot.camera.latest(inf).depth
    assert not np.array_equal(depth, pictures[0], equal_nan=True)


def at_block(sim: Sim) -> ComposedRobot:
    """Put the hand around the block, by the arm's own kinematics."""
    model = robot_model("frankie")
    target = looking_down(0.7, 0.0, TABLE_TOP + 0.03, yaw=np.pi / 2)
    q = FRANKIE.arm.ready.copy()
    for _ in range(200):
        bTe, J, *_ = model.kinematics(q)
        J = J[:, model.n_base :]
        error = np.concatenate([target.translation - bTe.translation, rotation_error(bTe, target)])
        q = q + np.linalg.pinv(J, rcond=1e-3) @ error * 0.3
    sim.body.q = q
    return sim.robot


def rotation_error(here: SE3, there: SE3) -> np.ndarray:
    return here.rotation @ pin.log3(here.rotation.T @ there.rotation)


def rise(sim: Sim) -> None:
    """The hand straight up at 0.2 m/s, for a second."""
    model = robot_model("frankie")
    for _ in range(100):
        _, J, *_ = model.kinematics(sim.robot.read().q)
        qd = np.linalg.pinv(J[:, model.n_base :]) @ np.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0])
        sim.robot.send(Command(base_twist=np.zeros(3), qd=qd))
        sim.clock.sleep_until(sim.clock.now() + 0.01)


def test_fingers_close_on_what_is_between_them_and_carry_it():
    sim = Sim(block())
    at_block(sim).grip(0.0, 20.0)
    assert sim.robot.read().gripper_moving
    sim.clock.sleep_until(1.0)
    state = sim.robot.read()
    assert not state.gripper_moving
    assert state.gripper_width == pytest.approx(0.04, abs=0.001)
    height = sim.world.find("block").pose.translation[2]
    up = np.zeros(7)
    up[1] = -0.3
    sim.drive(Command(base_twist=np.zeros(3), qd=up), 0.5)
    assert sim.world.find("block").pose.translation[2] > height + 0.03
    sim.robot.grip(0.08, 20.0)
    assert sim.world.find("block").pose.translation[2] == pytest.approx(height, abs=5e-3)


def test_fingers_that_stop_before_the_object_do_not_take_it():
    sim = Sim(block())
    at_block(sim).grip(0.06, 20.0)
    sim.clock.sleep_until(1.0)
    assert sim.robot.read().gripper_width == pytest.approx(0.06)
    assert sim.world.held is None


def test_fingers_that_press_on_what_they_cannot_hold_stop_and_slip_off_when_the_hand_rises():
    sim = Sim(block(mass=20.0))
    at_block(sim).grip(0.0, 20.0)
    sim.clock.sleep_until(1.0)
    state = sim.robot.read()
    assert sim.world.held is None
    assert not state.gripper_moving
    assert state.gripper_width == pytest.approx(0.04, abs=0.001)
    rise(sim)
    state = sim.robot.read()
    assert state.gripper_width == 0.0
    assert not state.gripper_moving
    assert state.faults == ()


def test_running_into_something_trips_the_reflex_until_it_is_cleared():
    sim = Sim(block(half=(0.02, 0.03, 0.05)))
    at_block(sim)
    sim.body.q = sim.body.q + np.array([0.1, 0, 0, 0, 0, 0, 0])
    sim.body._integrate(Command.stop(), 0.01)
    state = sim.robot.read()
    assert [fault.kind.value for fault in state.faults] == ["reflex"]
    assert state.faults[0].text == "the hand hit block"
    assert state.faults[0].clearable
    before = state.q
    applied = sim.robot.send(Command(base_twist=np.zeros(3), qd=np.full(7, 0.2)))
    assert not applied.qd.any()
    sim.clock.sleep_until(sim.clock.now() + 0.1)
    np.testing.assert_array_equal(sim.robot.read().q, before)
    sim.robot.recover()
    assert sim.robot.read().faults == ()
    up = np.zeros(7)
    up[1] = -0.3
    sim.drive(Command(base_twist=np.zeros(3), qd=up), 0.5)
    assert sim.robot.read().faults == ()  # moving off what was hit is allowed
