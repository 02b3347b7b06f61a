"""What nobody has told the robot about is not hit if its camera has seen it."""

import numpy as np
from harness import TABLE_TOP, ByHand, Harness, block, looking_down
from pinocchio import SE3
from solid_world import box

from behaviours import DepthObstacles
from controller import BaseGoal, PoseGoal
from hw import TaskTime
from hw.sim import World
from robots import Geom, Plane

FLOOR = Geom(Plane(), SE3.Identity(), "floor")


TABLE = box("table", (0.9, 0.0, 0.25), (0.4, 0.6, 0.25))
CRATE = box("crate", (2.2, 0.05, 0.15), (0.15, 0.15, 0.15))
POST = box("post", (0.7, 0.05, 0.62), (0.04, 0.04, 0.12))


class Seeing(Harness):
    """The simulated robot among things, some of which are on no map."""

    def __init__(self, *unknown, known=(), objects=(), sees=True, executor=None) -> None:
        super().__init__(World([FLOOR, *known, *unknown], list(objects)))
        self.context.around.fixtures = tuple(known)
        if sees:
            self.context.around.depth_obstacles = DepthObstacles(self.robot.description, executor)

    @property
    def cloud(self) -> np.ndarray:
        return self.context.around.depth_obstacles.cloud.points

    def go(self, goal, seconds, each=lambda state: None):
        for _ in range(round(seconds * 100)):
            report = self.pursue(goal)
            each(self.context.state)
            if report.arrived:
                break
        return report


def over(y: float, z: float) -> SE3:
    """Beside the post on the table, the narrow side of the hand towards it."""
    return looking_down(0.7, y, z, yaw=np.pi / 2)


def footprint_gap(state, geom) -> float:
    """From the outline of the base, in points 2 cm apart, to an upright box; negative inside."""
    x, y = np.meshgrid(np.linspace(-0.35, 0.35, 36), np.linspace(-0.25, 0.25, 26))
    points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    world = points @ state.oTb.rotation.T + state.oTb.translation
    beyond = np.abs(world - geom.pose.translation)[:, :2] - np.array(geom.shape.half[:2])
    return float(beyond.max(axis=1).min())


def filled(low, high) -> np.ndarray:
    """(N, 3) points 1 cm apart in a box."""
    edges = [np.arange(a, b + 1e-9, 0.01) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*edges), axis=-1).reshape(-1, 3)


PALM = filled((-0.03, -0.1, -0.13), (0.03, 0.1, -0.04))
HAND = np.concatenate([PALM, filled((-0.01, -0.05, -0.04), (0.01, 0.05, 0.0))])
"""With open fingers, in e."""


def hand_gap(model, state, geom) -> float:
    """From the hand to a box that stands upright; negative inside."""
    oTe = model.end_effector(state.oTb, state.q)
    points = HAND @ oTe.rotation.T + oTe.translation - geom.pose.translation
    return float((np.abs(points) - np.array(geom.shape.half)).max(axis=1).min())


def driven_at_the_crate(sees: bool, seconds: float) -> float:
    """The smallest gap on the way."""
    robot, gaps = Seeing(CRATE, sees=sees), []
    goal = BaseGoal(target=SE3(np.eye(3), np.array([3.2, 0.0, 0.0])))
    robot.go(goal, seconds, lambda state: gaps.append(footprint_gap(state, CRATE)))
    return min(gaps)


def test_a_crate_on_the_floor_is_not_rammed():
    assert driven_at_the_crate(sees=False, seconds=3.5) < 0.005  # the crate stops it
    assert driven_at_the_crate(sees=True, seconds=6.0) > 0.005


def swept_at_the_post(sees: bool) -> tuple[float, list[str]]:
    """The smallest gap of a hand that has looked down on table and post, and the faults."""
    robot, gaps = Seeing(POST, known=(TABLE,), sees=sees), []
    robot.go(PoseGoal(target=over(-0.2, 1.0)), 5.0)
    robot.go(PoseGoal(target=over(-0.2, 0.62), straight=True, speed=0.3), 5.0)
    low = PoseGoal(target=over(0.3, 0.62), straight=True, speed=0.3)
    robot.go(low, 5.0, lambda state: gaps.append(hand_gap(robot.context.model, state, POST)))
    return min(gaps), [fault.text for fault in robot.robot.read().faults]


def test_a_post_on_the_table_is_not_hit_by_the_hand():
    _, faults = swept_at_the_post(sees=False)
    assert faults == ["the camera hit post"]  # which is beside the hand
    gap, faults = swept_at_the_post(sees=True)
    assert gap > 0.005
    assert not faults


def test_neither_the_hand_nor_what_it_holds_is_an_obstacle():
    """A long object, of which only its width is known, carried over the table."""
    rod = block(half=(0.09, 0.015, 0.02), x=0.7)
    robot = Seeing(known=(TABLE,), objects=(rod,))
    robot.go(PoseGoal(target=looking_down(0.7, 0.0, 0.7)), 6.0)
    down = PoseGoal(
        target=looking_down(0.7, 0.0, 0.52), straight=True, hand_may_touch=True, speed=0.3
    )
    robot.go(down, 6.0)
    robot.grip(0.0)
    assert robot.world.held is rod
    robot.context.log.grip_height = 0.02
    robot.context.log.attempt(TaskTime(0.0), TaskTime(1.0))
    up = PoseGoal(target=looking_down(0.7, 0.0, 0.8), straight=True, hand_may_touch=True, speed=0.3)
    robot.go(up, 4.0)
    report = robot.go(PoseGoal(target=looking_down(0.9, 0.1, 0.8)), 6.0)
    assert report.arrived
    assert len(robot.cloud) > 100
    assert robot.cloud[:, 2].max() < TABLE_TOP + 0.1  # and the hand is 0.3 m above it


def test_what_was_seen_before_the_base_was_localised_anew_is_forgotten():
    robot = Seeing(known=(TABLE,))
    robot.go(PoseGoal(target=looking_down(0.7, 0.0, 0.9)), 3.0)
    assert len(robot.cloud) > 100
    robot.context.around.depth_obstacles.relocalise(robot.clock.now() + 10.0)
    robot.go(None, 0.3)
    assert not len(robot.cloud)


def test_frames_that_are_worked_on_beside_the_loop_come_later():
    waiting = ByHand()
    robot = Seeing(known=(TABLE,), executor=waiting)
    robot.go(None, 0.3)
    assert not len(robot.cloud)
    assert len(waiting.waiting) == 1
    for _ in range(3):
        waiting.work()
        robot.go(None, 0.2)
    assert len(robot.cloud) > 50
