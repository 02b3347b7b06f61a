"""Somebody walks, and the base gives way: judged by geometry of its own."""

import numpy as np
import pytest
from motion import run_to, tool_pose
from pinocchio import SE3

from controller import Obstacle, PoseGoal, Surroundings, robot_model
from robots import Cylinder, Geom

RADIUS = 0.25
GOAL = (4.5, 0.0, 0.8)


class Walk:
    """Somebody who walks straight on."""

    def __init__(self, start, velocity):
        self.start, self.velocity = np.array(start), np.array(velocity)

    def at(self, time):
        return self.start + self.velocity * time

    def obstacle(self, time):
        centre = np.array([*self.at(time), 0.85])
        geom = Geom(Cylinder(RADIUS, 0.85), SE3(np.eye(3), centre), "somebody")
        return Obstacle(geom, np.array([*self.velocity, 0.0]))


def gap(model, state, where) -> float:
    """From somebody to the base, a rectangle, and to the line from the arm's foot to the hand."""
    at = state.mTb.actInv(np.array([*where, 0.0]))[:2]
    beyond = np.abs(at) - np.array(model.description.base.size[:2]) / 2.0
    base = np.hypot(*np.maximum(beyond, 0.0)) + min(beyond.max(), 0.0)
    foot = model.description.bTa.translation[:2]
    arm = state.mTb.actInv(model.end_effector(state.mTb, state.q).translation)[:2] - foot
    along = np.clip((at - foot) @ arm / (arm @ arm), 0.0, 1.0)
    return min(base, float(np.linalg.norm(at - foot - along * arm))) - RADIUS


def drive(robot, walk, seconds, known=True):
    """Gaps and reports of a robot that starts at rest in the origin."""
    run = run_to(
        PoseGoal(target=tool_pose(*GOAL)),
        robot=robot,
        seconds=seconds,
        around=lambda time: Surroundings(moving=(walk.obstacle(time),) if known else ()),
        late=True,
        stays=True,
    )
    model = robot_model(robot)
    gaps = [gap(model, state, walk.at(0.01 * k)) for k, state in enumerate(run.states)]
    return np.array(gaps), run.reports


WALKS = {
    "from the left": Walk((2.0, 2.2), (0.0, -0.8)),
    "from behind": Walk((-2.5, 0.15), (0.9, 0.0)),
    "aslant": Walk((4.0, 2.0), (-0.6, -0.55)),
}


@pytest.mark.parametrize(
    ("robot", "walk"),
    [("frankie", "from the left"), ("frankie", "from behind"), ("omni", "aslant")],
)
def test_who_crosses_its_way_is_not_touched_and_the_goal_is_reached(robot, walk):
    gaps, reports = drive(robot, WALKS[walk], 15.0)
    assert gaps.min() > 0.0
    assert reports[-1].arrived


def test_without_eyes_they_would_meet():
    assert drive("frankie", WALKS["from the left"], 8.0, known=False)[0].min() < 0.0


def test_who_waits_says_for_whom_and_keeps_its_stance():
    """Somebody walks along in front of the goal, so slowly that patience would be over."""
    walk = Walk((3.0, 1.3), (0.0, -0.25))
    gaps, reports = drive("frankie", walk, 20.0)
    waited = [report for report in reports if report.waits_for]
    assert {report.waits_for for report in waited} == {"somebody"}
    assert not any(report.detour for report in reports)
    assert gaps.min() > 0.0
    assert reports[-1].arrived
