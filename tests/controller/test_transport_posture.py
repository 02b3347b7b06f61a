"""Through a passage that is narrower than the arm reaches, the arm is carried."""

from math import pi

import numpy as np
import pinocchio as pin
import pytest
from motion import run_to, tool_pose
from pinocchio import SE3
from test_floor_map import box

from config.planar import Pose2D
from controller import HolisticController, PoseGoal, Surroundings, robot_model
from controller.collision.collision_model import CollisionModel
from controller.floor.floor_map import FloorMap
from controller.stance.docking import ROOM
from controller.stance.free_space import FreeSpace, se3_of
from controller.stance.stance import Stance
from controller.stance.transport_posture import TransportPosture

CORRIDOR = (
    box(1.25, 2.55, 1.0, 4.0, height=1.6),
    box(1.25, -2.55, 1.0, 4.0, height=1.6),
    box(1.7, 0.5, 0.1, 0.1, height=1.6),
    box(1.7, -0.5, 0.1, 0.1, height=1.6),
)
"""1.1 m wide, with a door of 0.9 m, between two rooms."""
_PACE = 0.4
"""Share of the base's time that the arm takes."""
TABLE = box(0.0, 1.6, 1.2, 0.6, height=0.5)


@pytest.fixture
def model():
    return robot_model("frankie")


def test_the_arm_gets_through_a_corridor_without_touching_it(model):
    """From a goal on one side to one behind the wall on the other."""
    controller, before = HolisticController(model), {}
    around = Surroundings(fixtures=(*CORRIDOR, TABLE))
    judge = CollisionModel(model, around)
    over_table = SE3(pin.rpy.rpyToMatrix(pi, 0.0, pi / 2.0), np.array([0.0, 1.4, 0.85]))
    for mTe in (tool_pose(2.935, 0.0, 0.85), over_table):
        goal = PoseGoal(target=mTe)
        run = run_to(goal, controller=controller, around=around, seconds=11.0, **before)
        assert run.arrived
        assert min(judge.clearance(state.q, state.mTb) for state in run.states[::5]) > 0.0
        before = {"state": run.state, "last": run.commands[-1]}


def test_the_arm_is_carried_up_to_the_door_and_no_farther(model):
    """A posture that reaches out to the side meets the post of a door; an open floor is free."""
    ready = model.description.arm.ready
    sideways = ready + np.array([pi / 2.0, 0.6, 0.0, 0.6, 0.0, 0.0, 0.0])
    way = np.array([[x, 0.0, 0.0] for x in np.linspace(-2.0, 3.0, 101)])
    door = FreeSpace(model, FloorMap(CORRIDOR[2:], model.description))
    stance = Stance(sideways, model.bTe(sideways), reverse=False)
    carrying, carried, q = TransportPosture(model, _PACE), {}, ready
    for pose in way:
        base, times = Pose2D(*pose.tolist()), (3.0 - float(pose[0]), 1.0)
        posture = carrying.posture(door, way, base, q, stance, times)
        if posture is not None:
            np.testing.assert_array_equal(posture, ready)
        carried[float(pose[0])] = posture is not None
        aim = sideways if posture is None else posture
        q = q + np.clip(aim - q, -0.08, 0.08)  # 1.6 rad/s, the base at 1 m/s
        assert door.nearest(se3_of(base), q, door.parts, ROOM).distance == ROOM
    begun, ended = (f(x for x, is_carried in carried.items() if is_carried) for f in (min, max))
    assert begun < 0.0  # in time: the posts are at 1.6 m
    assert 1.0 < ended < 2.0
    room = FreeSpace(model, FloorMap((), model.description))
    start = Pose2D(-2.0, 0.0, 0.0)
    assert (
        TransportPosture(model, _PACE).posture(room, way, start, ready, stance, (5.0, 1.0)) is None
    )
