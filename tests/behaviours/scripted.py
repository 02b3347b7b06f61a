"""A real context on a robot that is where a test puts it, with fingers and pictures as it says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from harness import table_world
from pinocchio import SE3
from py_trees.common import Status

from behaviours import Around, Context, Leaf, Now, Vision
from controller import MotionGoal, PoseGoal, StepReport, robot_model
from hw import DepthFrame, RobotState, SimClock, TaskClock, TaskTime
from hw.sim import DepthRenderer, SimObject
from robots import Geom, load_robot

FRANKIE = load_robot("frankie")
HERE = SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.7, 0.0, 0.53]))
"""A hand that points down."""


def up(by: float, hand: SE3 = HERE) -> SE3:
    """The hand, so much higher [m]."""
    return SE3(hand.rotation, hand.translation + np.array([0.0, 0.0, by]))


class Script:
    """A robot in a room of furniture, one reading after the other.

    Args:
        fixtures: that the camera sees, and the map has.
        hand: where it is at first.
        robot: its description.
    """

    def __init__(self, *fixtures: Geom, hand: SE3 = HERE, robot=FRANKIE) -> None:
        self.seen: Sequence[Geom] = fixtures
        self.clock, self.grips = SimClock(), []
        self._frame: DepthFrame | None = None
        self._renderer = DepthRenderer(robot.camera.intrinsics)
        self._robot = SimpleNamespace(
            description=robot, grip=lambda width, force: self.grips.append(width), laser=None
        )
        self.model = robot_model("frankie")
        q = robot.arm.ready
        self._bTe = self.model.end_effector(SE3.Identity(), q)
        self.state = RobotState(
            stamp=0.0,
            oTb=hand * self._bTe.inverse(),
            base_twist=np.zeros(3),
            q=q,
            qd=np.zeros(7),
            gripper_width=robot.gripper.opening,
            gripper_moving=False,
        )
        self.context = Context(
            robot=self._robot,
            model=self.model,
            clock=TaskClock(self.clock),
            vision=Vision(self, None),
            now=Now(state=self.state),
            around=Around(fixtures=fixtures),
        )

    @property
    def goal(self) -> MotionGoal | None:
        """What the leaf wants."""
        return self.context.now.intent and self.context.now.intent.goal

    def holds(self, width: float = 0.04, height: float = 0.03) -> None:
        """The fingers have closed on something so wide [m], so high over what it stood on [m]."""
        log = self.context.log
        log.gripped(0.0)
        self.rest(width)
        log.grip_height, log.last_grasp = height, HERE
        log.attempt(TaskTime(0.0), TaskTime(0.1))

    def rest(self, width: float | None = None, s: float = 0.4) -> None:
        """Without a leaf, with the fingers at rest."""
        for _ in range(round(s / 0.05)):
            self.reads(width=width, after=0.05)

    def reads(self, hand: SE3 | None = None, after: float = 0.01, width=None, **rest) -> None:
        """The next reading, so much later [s]: what is not said is as before.

        The base comes with the hand, in so long a gap that no localisation seems to have jumped.
        """
        if hand is not None:
            after, rest["oTb"] = max(after, 0.3), hand * self._bTe.inverse()
        if width is not None:
            rest["gripper_width"] = width
        self.clock.sleep_until(self.clock.now() + after)
        self.state = replace(self.state, stamp=self.clock.now(), **rest)
        self.context.begin_tick(self.state)

    def report(self, away: float = 0.0, **rest) -> None:
        """What the controller says of the goal of this tick; it has arrived if it is not away."""
        one = StepReport(
            arrived=not away,
            position_error=away,
            orientation_error=0.0,
            manipulability=0.1,
            heading_error=0.0,
            bTe=self._bTe,
        )
        self.context.end_tick(one._replace(**rest))

    def latest(self, max_age: float) -> DepthFrame | None:
        """A picture of this reading, if there is anything to see."""
        stamp, camera = self.state.stamp, self._robot.description.camera
        if self.seen and (self._frame is None or self._frame.stamp < stamp):
            oTc = self.model.end_effector(self.state.oTb, self.state.q) * camera.eTc
            depth, intrinsics = self._renderer.render(self.seen, oTc), camera.intrinsics
            self._frame = DepthFrame(depth=depth, intrinsics=intrinsics, oTc=oTc, stamp=stamp)
        return self._frame

    def shows(self, *objects: SimObject) -> Script:
        """The camera sees the table of `harness.table_world`, and what stands on it."""
        self.seen = (*table_world().fixtures, *(part for one in objects for part in one.placed()))
        return self

    def follow(self, leaf: Leaf, until: Callable[[], bool] = lambda: False) -> str:
        """Let hand and fingers be where the leaf wants them until it ends; what it says then."""
        for _ in range(400):
            goal, width = self.goal, self.grips[-1] if self.grips else None
            hand = goal.target if isinstance(goal, PoseGoal) else None
            moving = width not in (None, self.state.gripper_width)
            self.reads(hand, after=0.1, width=width, gripper_moving=moving)
            leaf.tick_once()
            self.report(0.0)
            if leaf.status is not Status.RUNNING or until():
                break
        return leaf.feedback_message
