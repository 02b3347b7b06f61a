"""A base stands so that it is soon on its way to where the task goes next."""

from math import atan2

import numpy as np
import pytest
from motion import READY, tool_pose
from pinocchio import SE3
from test_stance_search import ORIGIN, box

from controller import RobotModel, SelfCollision, robot_model
from controller.floor.base_drive import Pose2D, wrap
from controller.floor.floor_map import FloorMap
from controller.stance.free_space import FreeSpace
from controller.stance.posture_bank import bank
from controller.stance.search import StanceSearch

BESIDE_THE_WAY = tool_pose(3.0, 0.72, 0.85, yaw=np.pi / 2.0)
AHEAD = tool_pose(6.0, 0.0, 0.85)
BACK = tool_pose(0.0, -3.0, 0.85)
LONG_TABLE = box("table", (3.0, 0.9, 0.35), (1.0, 0.3, 0.35))


def base_for(
    model: RobotModel, wTe: SE3, onward: SE3 | None, fixtures=(), wTb: Pose2D = ORIGIN
) -> Pose2D:
    space = FreeSpace(model, FloorMap(fixtures, model.description)) if fixtures else None
    body, postures = SelfCollision(model), bank(model.description)
    here = StanceSearch(model, postures, body, wTe, wTb, READY, space=space, next_goal=onward)
    found = here.finish()
    assert found is not None
    return found.base_for(wTe)


def turns(stood: Pose2D, to: SE3) -> float:
    """By how much a base turns on its way from where it was to a stance and on from there [rad]."""
    x, y, _ = to.translation
    into = atan2(stood.y, stood.x)
    out = atan2(y - stood.y, x - stood.x)
    return abs(into) + abs(wrap(stood.heading - into)) + abs(wrap(out - stood.heading))


def test_a_base_that_knows_where_it_goes_next_hardly_turns_on_its_way_past_a_table():
    model, fixtures = robot_model("frankie"), (LONG_TABLE,)
    knowing = base_for(model, BESIDE_THE_WAY, AHEAD, fixtures)
    other = base_for(model, BESIDE_THE_WAY, BACK, fixtures)
    assert turns(knowing, AHEAD) < 0.4
    assert turns(knowing, AHEAD) < 0.5 * turns(other, AHEAD)


def test_a_base_that_comes_round_a_corner_stands_as_it_arrives():
    # As the crow flies it would come along -x; round the end of the wall it comes along y.
    wall = box("wall", (1.25, 2.55, 0.8), (0.5, 2.0, 0.8))
    table = box("table", (0.0, 1.6, 0.25), (0.6, 0.3, 0.25))
    over_table = tool_pose(0.0, 1.4, 0.85, yaw=np.pi / 2.0)
    behind_wall = Pose2D(2.2, 0.2, -0.5)
    stood = base_for(robot_model("frankie"), over_table, None, (wall, table), behind_wall)
    assert stood.heading < 2.5


@pytest.mark.parametrize("side", [-3.0, 3.0])
def test_a_holonomic_base_stands_on_the_side_that_it_leaves_to(side):
    model, wTe = robot_model("omni"), tool_pose(2.0, 0.0, 0.6)
    stood = base_for(model, wTe, tool_pose(2.0, side, 0.6))
    assert np.sign(stood.y) == np.sign(side)
