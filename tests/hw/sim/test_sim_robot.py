"""Kinematic robot: lag, exact arcs, frames, gripper and reflex."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from harness import block, table_world
from solid_world import Solid, box_at_the_hand

from hw.sim import kinematic_robot
from robots import load_robot

FRANKIE = load_robot("frankie")


def without_lag(description, *args):
    base = replace(description.base, lag=1e-6)
    return kinematic_robot(replace(description, base=base), *args)


def gripping(mass: float = 0.1, width: float = 0.0) -> Solid:
    """After the fingers have closed on a box."""
    pillar, thing = box_at_the_hand(mass)
    sim = Solid(pillar, objects=[thing])
    sim.robot.grip(width, 20.0)
    assert sim.robot.read().gripper_moving
    sim.clock.sleep_until(1.0)
    assert not sim.robot.read().gripper_moving
    return sim


def test_velocities_follow_commands_with_their_lag_and_without_commands_stop():
    sim = Solid()
    twist, qd = np.array([0.5, 0.0, 0.2]), np.full(7, 0.1)
    sim.drive(twist, qd, s=0.1)
    state = sim.robot.read()
    reached = 1.0 - np.exp(-0.1 / FRANKIE.base.lag)
    np.testing.assert_allclose(state.base_twist, reached * twist, rtol=1e-9)
    reached = 1.0 - np.exp(-0.1 / FRANKIE.arm.lag)
    np.testing.assert_allclose(state.qd, reached * qd, rtol=1e-9)
    sim.clock.sleep_until(sim.clock.now() + 2.0)
    state = sim.robot.read()
    assert np.abs(state.base_twist).max() < 1e-6
    assert np.abs(state.qd).max() < 1e-6


def test_a_constant_twist_drives_an_arc():
    sim = Solid(make=without_lag)
    v, w = 0.4, 0.8
    sim.drive((v, 0.0, w), s=2.0)
    angle, radius = w * 2.0, v / w
    expected = [radius * np.sin(angle), radius * (1.0 - np.cos(angle)), 0.0]
    np.testing.assert_allclose(sim.robot.read().oTb.translation, expected, atol=1e-9)
    sim = Solid(robot="omni", make=without_lag)
    sim.drive((0.0, 0.3, 0.0), s=1.0)
    np.testing.assert_allclose(sim.robot.read().oTb.translation, [0.0, 0.3, 0.0], atol=1e-9)


def test_frames_come_at_their_rate_and_depend_on_seed_and_time_only():
    def seeded(seed: int) -> Solid:
        def make(*args):
            return kinematic_robot(*args, seed=seed)

        return Solid(world=table_world(block()), make=make)

    sim, frames = seeded(3), []
    for _ in range(100):
        frames.append(sim.robot.camera.latest(inf))
        sim.clock.sleep_until(sim.clock.now() + 0.01)
    assert len({id(frame) for frame in frames}) == 30
    assert frames[0] is frames[1]
    assert frames[0].stamp == 0.0
    depths = [sim.robot.camera.latest(inf).depth]
    for seed in (3, 4):
        other = seeded(seed)
        other.clock.sleep_until(sim.clock.now())
        depths.append(other.robot.camera.latest(inf).depth)
    np.testing.assert_array_equal(depths[0], depths[1])
    assert not np.array_equal(depths[0], depths[2], equal_nan=True)


def test_fingers_that_cannot_hold_an_object_stop_and_slip_off_when_the_hand_rises():
    sim = gripping(mass=20.0)
    assert sim.world.held is None
    assert sim.robot.read().gripper_width == pytest.approx(0.04, abs=0.001)
    sim.rise(0.2)
    state = sim.robot.read()
    assert state.gripper_width == 0.0
    assert not state.gripper_moving
    assert state.faults == ()
