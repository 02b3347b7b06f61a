"""Grasps have the same outcome in the kinematic and in the physical world."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio import SE3, exp3, log3
from solid_world import FLOOR, TOOL, box, physical

from hw.sim import SimObject, World
from hw.sim.objects import OBJECT_CLASSES
from hw.sim.objects.making import make_object
from robots import Box, Cylinder, Geom, Shape, Sphere, load_robot

pytest.importorskip("mujoco", reason="needs the extra `physics`")

FRANKIE = load_robot("frankie")
TIP = FRANKIE.gripper.tip
ALONG_X = exp3(np.array([0.0, np.pi / 2.0, 0.0]))


def made_of(*shapes: tuple[Shape, float, float], mass: float = 0.1) -> SimObject:
    """Shapes along x, each with its place there and its height above the ground."""
    parts = [
        Geom(
            shape,
            SE3(ALONG_X if isinstance(shape, Cylinder) else np.eye(3), np.array([x, 0.0, z])),
            "thing",
        )
        for shape, x, z in shapes
    ]
    return SimObject(name="thing", parts=tuple(parts), mass=mass, pose=SE3.Identity())


def bar(mass: float) -> SimObject:
    return made_of((Box((0.15, 0.01, 0.01)), 0.0, 0.01), mass=mass)


def dumbbell() -> SimObject:
    ball = Sphere(0.02)
    return made_of((Cylinder(0.01, 0.04), 0.0, 0.02), (ball, 0.04, 0.02), (ball, -0.04, 0.02))


def bowl() -> SimObject:
    """Its rim on the other side of the origin."""
    rng = np.random.default_rng(0)
    return make_object("thing", OBJECT_CLASSES["bowl"], (0.006, 0.006), (0.2, 0.2), rng)


def by_rule_and_in_physics(
    thing: SimObject, x: float, tips: float, across: bool = False, friction: float = 0.5
) -> tuple[bool, bool]:
    """Whether it is held as it was grasped, at x from its origin, the tips so far above the ground.

    Across, the fingers close along its x axis instead of y. What swings in the hand is not held.
    """
    turn = exp3(np.array([0.0, 0.0, np.pi / 2.0])) if across else np.eye(3)
    ground = TOOL.translation[2] - TIP - tips
    to_hand = np.array([TOOL.translation[0], TOOL.translation[1], ground])
    lift = np.array([0.0, 0.0, thing.pose.translation[2]])
    thing.pose = SE3(turn, to_hand + lift - turn @ np.array([x, 0.0, 0.0]))
    thing.friction = friction
    middle = (to_hand[0] + 0.1, to_hand[1], ground / 2.0)
    pillar = box("pillar", middle, (0.33, 0.3, ground / 2.0))
    sim = physical(pillar, objects=[thing])
    state = sim.robot.read()
    rules = World([FLOOR, pillar], [replace(thing)])
    told = rules.close_fingers(sim.body.hand, state.gripper_width, 20.0)
    sim.robot.grip(0.0, 20.0)
    sim.drive(s=1.0)
    closed = sim.body.wTe.actInv(thing.pose)
    sim.rise()
    sim.drive(s=0.5)
    swung = np.linalg.norm(log3(closed.rotation.T @ sim.body.wTe.actInv(thing.pose).rotation))
    held = sim.world.supports() == {"thing": "hand"} and swung < 0.3
    return told.holding is not None, held


@pytest.mark.parametrize(
    ("thing", "x", "tips", "across", "held"),
    [
        (bar(0.6), 0.0, 0.003, False, True),
        (bar(0.05), -0.14, 0.003, False, True),
        (bar(0.6), -0.14, 0.003, False, False),
        (bar(0.1), 0.0, 0.0192, False, True),
        (bowl(), 0.0, 0.03, True, False),
        (dumbbell(), 0.02, 0.01, False, True),
        (dumbbell(), 0.04, 0.032, False, False),
    ],
)
def test_both_worlds_agree(thing, x, tips, across, held):
    assert by_rule_and_in_physics(thing, x, tips, across) == (held, held)
