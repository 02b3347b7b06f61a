"""Hand without an arm in the physical world."""

import numpy as np
import pytest
from pinocchio import SE3
from solid_world import box

from hw.sim import SimObject, World
from robots import Box, Geom, load_robot

pytest.importorskip("mujoco", reason="needs the extra `physics`")
from extensions.physics.floating_hand import FloatingHand

FRANKIE = load_robot("frankie")
DOWN = np.diag([1.0, -1.0, -1.0])
TOP = 0.4
HALF = (0.03, 0.02, 0.03)


def world_with() -> World:
    """A box on a table."""
    parts = (Geom(Box(HALF), SE3.Identity(), "box"),)
    here = SE3(np.eye(3), np.array([0.0, 0.0, TOP + HALF[2]]))
    thing = SimObject(name="box 1", parts=parts, mass=0.3, friction=0.5, pose=here)
    return World([box("table", (0.0, 0.0, TOP / 2.0), (0.3, 0.3, TOP / 2.0))], [thing])


def at(x: float, z: float) -> SE3:
    return SE3(DOWN, np.array([x, 0.0, TOP + z]))


def test_a_box_is_held_lifted_shaken_and_released():
    world = world_with()
    hand = FloatingHand(FRANKIE, world, at(0.0, 0.4))
    hand.settle(1.0)
    hand.move(at(0.0, 0.03), 0.2)
    hand.close(40.0, 0.3)
    hand.move(at(0.0, 0.23), 0.2)
    assert hand.pinched() is world.objects[0]
    hand.shake(np.array([0.015, 0.015, 0.015, 0.3]), 3.0, 1.5)
    hand.settle(0.5)
    assert hand.pinched() is world.objects[0]
    assert world.objects[0].pose.translation[2] == pytest.approx(TOP + 0.23, abs=0.01)
    assert hand.wTe.translation == pytest.approx(at(0.0, 0.23).translation, abs=1e-3)
    assert hand.hardest < 20.0
    hand.open(hand.opening)
    hand.settle(2.0)
    assert hand.pinched() is None
    assert world.objects[0].pose.translation[2] < TOP + 0.05


def test_what_the_hand_is_driven_into_is_felt():
    hand = FloatingHand(FRANKIE, world_with(), at(0.0, 0.4))
    hand.move(at(0.0, 0.2), 0.2)
    assert hand.hardest < 1.0
    hand.move(at(0.15, -0.02), 0.2)  # the fingers would be in the table
    assert hand.hardest > 60.0
    hand.put(at(0.0, 0.4), hand.opening)
    assert hand.hardest == 0.0


def test_a_hand_that_comes_level_lifts_what_it_grips() -> None:
    world = world_with()
    level = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]) @ DOWN
    at_box = SE3(level, np.array([-0.005, 0.0, TOP + 0.045]))
    before, above = (SE3(level, at_box.translation + d) for d in np.diag([-0.2, 0.0, 0.2])[[0, 2]])
    hand = FloatingHand(FRANKIE, world, before)
    hand.settle(1.0)
    hand.move(at_box, 0.2)
    assert hand.wTe.isApprox(at_box, 2e-3)
    assert hand.hardest < 20.0
    hand.close(40.0, 0.3)
    hand.move(above, 0.2)
    assert hand.pinched() is world.objects[0]
    assert world.objects[0].pose.translation[2] > TOP + 0.2
