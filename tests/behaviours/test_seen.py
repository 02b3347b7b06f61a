"""What nobody has told the robot about is not hit if its camera has seen it."""

from dataclasses import replace

import numpy as np
from harness import detector, looking_down
from pinocchio import SE3

from behaviours import Context, SeenObstacles, VisionInStep
from controller import BaseGoal, HolisticController, PoseGoal, robot_model
from hw import Gate, SimClock, TaskClock
from hw.sim import World, kinematic_robot
from robots import Box, Geom, Plane, load_robot

FLOOR = Geom(Plane(), SE3.Identity(), "floor")


def box(name, centre, half) -> Geom:
    return Geom(Box(half), SE3(np.eye(3), np.array(centre, dtype=float)), name)


TABLE = box("table", (0.9, 0.0, 0.25), (0.4, 0.6, 0.25))
CRATE = box("crate", (2.2, 0.05, 0.15), (0.15, 0.15, 0.15))
SIDEWAYS = np.pi / 2
POST = box("post", (0.7, 0.05, 0.62), (0.04, 0.04, 0.12))


class Seeing:
    """The simulated robot among things, some of which are on no map."""

    def __init__(self, *unknown, known=(), objects=(), sees=True) -> None:
        self.clock = SimClock()
        described = load_robot("frankie")
        # Rendering takes most of the time of a test.
        description = replace(described, camera=replace(described.camera, rate=10.0))
        self.world = World([FLOOR, *known, *unknown], list(objects))
        self.robot = kinematic_robot(description, self.world, self.clock, seed=1)
        self.robot.connect()
        self.model = robot_model("frankie")
        self.controller = HolisticController(robot_model("frankie"))
        self.gate = Gate(self.robot, description, 0.01)
        self.context = Context(
            robot=self.robot,
            model=self.model,
            clock=TaskClock(self.clock),
            vision=VisionInStep(self.robot.camera, detector()),
            state=self.robot.read(),
            fixtures=tuple(known),
            seen=SeenObstacles(description) if sees else None,
        )
        self.reports = []
        self._ticks = 0

    @property
    def cloud(self) -> np.ndarray:
        return self.context.seen.cloud.points

    def go(self, goal, seconds, each=lambda state: None):
        for _ in range(round(seconds * 100)):
            state = self.robot.read()
            self.context.begin_tick(state)
            around = self.context.surroundings
            command, report = self.controller.step(state, goal, self.gate.applied, around)
            self.gate.send(command, state, self.clock.now())
            self._ticks += 1
            self.clock.sleep_until(self._ticks * 0.01)
            self.reports.append(report)
            each(state)
            if report.arrived:
                break
        return report


def footprint_gap(state, geom) -> float:
    """From the outline of the base, in points 2 cm apart, to an upright box; negative inside."""
    x, y = np.meshgrid(np.linspace(-0.35, 0.35, 36), np.linspace(-0.25, 0.25, 26))
    points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    world = points @ state.wTb.rotation.T + state.wTb.translation
    beyond = np.abs(world - geom.pose.translation)[:, :2] - np.array(geom.shape.half[:2])
    return float(beyond.max(axis=1).min())


def filled(low, high) -> np.ndarray:
    """(N, 3) points 1 cm apart in a box."""
    edges = [np.arange(a, b + 1e-9, 0.01) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*edges), axis=-1).reshape(-1, 3)


HAND = np.concatenate(
    [
        filled((-0.03, -0.1, -0.13), (0.03, 0.1, -0.04)),
        filled((-0.01, -0.05, -0.04), (0.01, 0.05, 0.0)),
    ]
)
"""Palm and open fingers, in e."""


def hand_gap(model, state, geom) -> float:
    """From the hand to a box that stands upright; negative inside."""
    wTe = model.wTe(state.wTb, state.q)
    points = HAND @ wTe.rotation.T + wTe.translation - geom.pose.translation
    return float((np.abs(points) - np.array(geom.shape.half)).max(axis=1).min())


def test_a_crate_on_the_floor_is_not_rammed():
    nearest = {}
    for sees in (False, True):
        robot, gaps = Seeing(CRATE, sees=sees), []
        goal = BaseGoal(wTb=SE3(np.eye(3), np.array([3.2, 0.0, 0.0])))
        robot.go(goal, 6.0, lambda state: gaps.append(footprint_gap(state, CRATE)))
        nearest[sees] = min(gaps)
        print(sees, min(gaps), robot.reports[-1].nearest, robot.reports[-1].position_error)
    assert nearest[False] < -0.1
    assert nearest[True] > 0.005


def test_a_post_on_the_table_is_not_hit_by_the_hand():
    nearest, hits = {}, {}
    for sees in (False, True):
        robot, gaps = Seeing(POST, known=(TABLE,), sees=sees), []
        robot.go(PoseGoal(wTe=looking_down(0.7, -0.2, 1.0, SIDEWAYS)), 5.0)
        robot.go(
            PoseGoal(wTe=looking_down(0.7, -0.2, 0.62, SIDEWAYS), straight=True, speed=0.3), 5.0
        )
        low = PoseGoal(wTe=looking_down(0.7, 0.3, 0.62, SIDEWAYS), straight=True, speed=0.3)
        robot.go(low, 5.0, lambda state: gaps.append(hand_gap(robot.model, state, POST)))
        nearest[sees] = min(gaps)
        hits[sees] = [fault.text for fault in robot.robot.read().faults]
        print(nearest, hits)
    assert nearest[False] < 0.005
    assert hits[False] == ["the hand hit post"]
    assert nearest[True] > 0.008
    assert not hits[True]
