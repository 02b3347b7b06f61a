"""The arm compensates for a base that follows late; only what the robot got is taken off again."""

import numpy as np
import pytest
from motion import State
from pinocchio import SE3

from controller import Command, HolisticController, Obstacle, PoseGoal, Surroundings, robot_model
from robots import Cylinder, Geom


def somebody(x: float, speed: float) -> Obstacle:
    """Who walks towards the robot."""
    geom = Geom(Cylinder(0.25, 0.85), SE3(np.eye(3), np.array([x, 0.0, 0.85])), "somebody")
    return Obstacle(geom, np.array([-speed, 0.0, 0.0]))


class Rolling:
    """A controller, 7 mm before a straight goal, of a base that still rolls."""

    def __init__(self):
        model = robot_model("frankie")
        self.controller, self.state = HolisticController(model), State()
        mTe = model.end_effector(self.state.mTb, self.state.q)
        self.goal = PoseGoal(
            target=SE3(np.eye(3), np.array([0.007, 0.0, 0.0])) * mTe, straight=True
        )
        self.last = Command(base_twist=np.array([0.05, 0.0, 0.0]), qd=np.zeros(7))
        self.taken_off = []
        without = self.controller._uncompensated

        def spied(applied):
            self.taken_off.append(float(np.abs(applied - without(applied)).max()))
            return without(applied)

        self.controller._uncompensated = spied
        self.step()
        self.last = Command.stop(7)

    def step(self, *moving):
        around = Surroundings(moving=moving)
        command, self.report = self.controller.step(self.state, self.goal, self.last, around)
        return command


def test_what_the_robot_got_is_taken_off():
    rolling = Rolling()
    rolling.last = rolling.step()
    rolling.step()
    assert rolling.taken_off[-1] > 1e-2


def test_what_gave_way_to_somebody_is_not():
    rolling = Rolling()
    rolling.last = rolling.step(somebody(1.3, 0.9))
    assert np.abs(rolling.last.base_twist).max() > 1e-3  # it does give way
    rolling.step()
    assert rolling.taken_off[-1] == 0.0


def test_what_the_gate_refused_is_not():
    rolling = Rolling()
    rolling.step()
    rolling.step()  # the robot still does what it did
    assert rolling.taken_off[-1] == 0.0


def test_the_slack_is_that_of_the_command_which_is_sent():
    rolling, sent, twists = Rolling(), np.full(9, 0.01), []
    rolling.step()
    assert rolling.controller._compensated is not None
    assert rolling.report.slack < 0.02  # what the base does by its lag is no slack

    def gives_way(now, task, *others):
        rolling.controller._compensated = None
        twists.append(task.aim.twist - now.kinematics.J @ sent)
        return sent

    rolling.controller._give_way = gives_way
    rolling.step()
    assert rolling.report.slack == pytest.approx(np.linalg.norm(twists[0]))
