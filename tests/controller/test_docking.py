"""Into a shelf: the base goes straight in from where the arm had room to unfold."""

import numpy as np
import pinocchio as pin
import pytest
from motion import READY, run_to
from pinocchio import SE3

from config.planar import Pose2D
from controller import ControllerSettings, PoseGoal, SelfCollision, Surroundings, robot_model
from controller.collision.collision_model import CollisionModel, CollisionModels
from controller.stance.docking import ROOM, YIELD
from controller.stance.finder import StanceFinder
from controller.stance.free_space import se3_of
from controller.stance.stance import Stance
from controller.stance.stance_approach import Approach, Phase
from robots import Box, Geom


def shelf(mTs: SE3, width: float, depth: float, boards: tuple[float, ...]) -> tuple[Geom, ...]:
    """Boards between two sides, before a back; open towards -x."""
    thin, tall = 0.01, boards[-1] / 2.0 + 0.01
    parts = [("board", (depth / 2, width / 2, thin), (0.0, 0.0, z)) for z in boards]
    parts += [("side", (depth / 2, thin, tall), (0.0, y, tall)) for y in (-width / 2, width / 2)]
    parts += [("back", (thin, width / 2, tall), (depth / 2, 0.0, tall))]
    return tuple(
        Geom(Box(half), mTs * SE3(np.eye(3), np.array(centre)), f"shelf/{name}")
        for name, half, centre in parts
    )


def upright(x: float, y: float, yaw: float) -> SE3:
    return SE3(pin.utils.rotate("z", yaw), np.array([x, y, 0.0]))


TURNED = shelf(upright(-2.103, -0.375, -2.361), 1.34, 0.306, (0.075, 0.484, 0.845, 1.27, 1.719))
"""Turned away from the start, so that the base drives round it and comes from the side."""
LOW = SE3(
    np.array([[0.6651, 0.6155, -0.423], [-0.3041, -0.2941, -0.9061], [-0.6821, 0.7312, -0.0084]]),
    np.array([-2.212, -0.279, 0.226]),
)
FACING = shelf(upright(2.615, 1.172, 0.049), 0.803, 0.379, (0.112, 0.592, 1.063, 1.443))
MIDDLE = SE3(
    np.array([[-0.1195, 0.1291, 0.9844], [-0.1889, 0.9703, -0.1502], [-0.9746, -0.2039, -0.0915]]),
    np.array([2.520, 1.086, 0.933]),
)


def rigid(mTe: SE3) -> SE3:
    """The same with a rotation that is one to the last digit."""
    return SE3(pin.Quaternion(mTe.rotation).normalized().toRotationMatrix(), mTe.translation)


@pytest.mark.parametrize(
    ("robot", "around", "mTe"), [("omni", TURNED, LOW), ("frankie", FACING, MIDDLE)]
)
def test_the_hand_goes_into_its_compartment_at_the_first_attempt(robot, around, mTe):
    """Coming from the side with the arm stretched out, both were caught by a board for good."""
    model = robot_model(robot)
    surroundings = Surroundings(fixtures=around)
    judge = CollisionModel(model, surroundings)
    run = run_to(PoseGoal(target=rigid(mTe)), robot=robot, around=surroundings, seconds=10.0)
    assert run.arrived
    assert not any(report.detour for report in run.reports)
    assert min(judge.clearance(state.q, state.mTb) for state in run.states[::5]) > 0.0


@pytest.mark.parametrize("robot", ["frankie", "omni"])
def test_where_the_base_goes_in_the_arm_has_room_and_keeps_it(robot):
    model, mTe = robot_model(robot), rigid(MIDDLE)
    finder = StanceFinder(model, SelfCollision(model), CollisionModels(model))
    finder.update(Surroundings(fixtures=FACING))
    stance = finder.search(mTe, Pose2D(0.0, 0.0, 0.0), model.description.arm.ready).finish()
    base, space = stance.base_for(mTe), finder.space

    def room(share: float) -> float:
        place = se3_of(base.moved(share * stance.dock))
        return space.nearest(place, stance.q, space.parts, ROOM).distance

    assert room(1.0) == ROOM
    assert min(map(room, np.linspace(0.0, 1.0, 9))) > room(0.0) - 2.0 * YIELD


@pytest.mark.parametrize(("x", "backs_out"), [(0.0, True), (-0.3, False)])
def test_a_base_that_has_passed_its_dock_backs_out_to_it(x, backs_out):
    model, settings, q = robot_model("frankie"), ControllerSettings(), READY
    finder = StanceFinder(model, SelfCollision(model), CollisionModels(model))
    approach = Approach(model, settings, finder)
    stance = Stance(q + 1.0, model.bTe(q + 1.0), reverse=False, dock=-0.2)
    goal = PoseGoal(target=SE3.Identity())
    here = stance, Pose2D(0.0, 0.0, 0.0), goal, 1.0, Pose2D(x, 0.02, 0.5), q
    approach.remaining(*here)
    approach.phase = Phase.TO_DOCK
    assert approach.remaining(*here).lead.reverse == backs_out
