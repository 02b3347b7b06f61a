"""A harness for one behaviour: the simulated robot, the real controller and gate, and a clock."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.behaviours import Running
from py_trees.common import Status

from app.core.setup import load_world_model
from behaviours import Around, Context, Intent, Leaf, Now, Place, Region, Vision
from controller import (
    Command,
    HolisticController,
    KinematicState,
    MotionGoal,
    PoseGoal,
    StepReport,
    robot_model,
)
from hw import (
    Camera,
    Fault,
    FaultKind,
    Gate,
    RobotState,
    RobotWrapper,
    SimClock,
    TaskClock,
    TaskTime,
    WallClock,
    find_world,
    world_names,
)
from hw.sim import SimObject, SimulatedWorld, World, kinematic_robot
from hw.sim.body import Dynamics
from perception import GraspDetector
from robots import Box, Geom, Plane, load_robot
from trees.language import intent_of

TABLE_TOP = 0.5
SIMULATORS = [one for one in world_names() if isinstance(find_world(one), SimulatedWorld)]


def _over_the_top(name: str, x: float, length: float) -> Region:
    pose = SE3(np.eye(3), np.array([x, 0.0, TABLE_TOP + 0.1]))
    return Region(name=name, mTr=pose, size=np.array([length, 0.4, 0.2]))


ON_TABLE = _over_the_top("table", 0.7, 0.4)
FAR = _over_the_top("table", 0.85, 0.3)
"""Six places in two rows; the far one has those with even numbers, and is filled first."""
SPOT = _over_the_top("spot", 0.75, 0.4)


@cache
def detector() -> GraspDetector:
    """The real one, loaded once."""
    return GraspDetector.shipped(load_robot("frankie").gripper)


def block(
    half=(0.02, 0.03, 0.025), x: float = 0.7, y: float = 0.0, name="block", mass: float = 0.1
) -> SimObject:
    """A wooden block standing on the table."""
    parts = (Geom(Box(half), SE3.Identity(), name),)
    pose = SE3(np.eye(3), np.array([x, y, TABLE_TOP + half[2]]))
    return SimObject(name=name, parts=parts, mass=mass, pose=pose)


def table_world(*objects: SimObject) -> World:
    middle = SE3(np.eye(3), np.array([0.8, 0.0, TABLE_TOP / 2]))
    table = Geom(Box((0.4, 0.4, TABLE_TOP / 2)), middle, "table")
    return World([*open_floor().fixtures, table], list(objects))


def open_floor() -> World:
    """Nothing stands around."""
    return World([Geom(Plane(), SE3.Identity(), "floor")], [])


def driving(speed: float) -> Command:
    return Command(base_twist=np.array([speed, 0.0, 0.0]), qd=np.zeros(7))


def looking_down(x: float, y: float, z: float, yaw: float = 0.0) -> SE3:
    return SE3(pin.rpy.rpyToMatrix(np.pi, 0.0, yaw), np.array([x, y, z]))


class Stubborn(RobotWrapper):
    """The simulated robot with what can go wrong under the test's control."""

    faults: tuple[Fault, ...] = ()
    blind = False
    stuck = False
    incurable = False
    restless = False

    def read(self) -> RobotState:
        state = super().read()
        moving = state.gripper_moving or self.restless
        return replace(state, faults=(*state.faults, *self.faults), gripper_moving=moving)

    def recover(self) -> None:
        super().recover()
        if not self.incurable:
            self.faults = tuple(fault for fault in self.faults if not fault.clearable)

    @property
    def camera(self) -> Camera:
        return SimpleNamespace(latest=lambda max_age: None) if self.blind else super().camera

    def send(self, command):
        return super().send(Command.stop(7) if self.stuck else command)


class Eyelid:
    """The robot's camera, looked up at every call: a test may blind it at any time."""

    def __init__(self, robot: Stubborn) -> None:
        self._robot = robot

    def latest(self, max_age: float):
        return self._robot.camera.latest(max_age)


class ByHand:
    """An executor whose work is done when the test says so."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Future, Callable, tuple]] = []

    def submit(self, fn, *args) -> Future:
        self.waiting.append((Future(), fn, args))
        return self.waiting[-1][0]

    def work(self) -> None:
        future, fn, args = self.waiting.pop()
        future.set_result(fn(*args))

    def shutdown(self, **_) -> None:
        self.waiting.clear()


REFLEX = Fault(kind=FaultKind.REFLEX, text="the arm hit something", clearable=True)
BUTTON = Fault(kind=FaultKind.EMERGENCY_STOP, text="emergency stop pressed", clearable=False)


class Harness:
    """Runs one leaf as the session would."""

    def __init__(
        self,
        world: World | None = None,
        robot: str = "frankie",
        dynamics: Dynamics | None = None,
        real_clock: bool = False,
        at: tuple[np.ndarray, SE3] | None = None,
    ) -> None:
        self.clock = WallClock() if real_clock else SimClock()
        self.world = world or open_floor()
        described = load_robot(robot)
        # Rendering takes most of the time of a test.
        description = replace(described, camera=replace(described.camera, rate=10.0))
        driver = kinematic_robot(description, self.world, self.clock, seed=1, dynamics=dynamics)
        if at is not None:
            body = driver._arm.body
            body.q, body.wTb = (each.copy() for each in at)
        self.robot = Stubborn(driver)
        self.robot.connect()
        self.controller = HolisticController(robot_model(robot))
        self.gate = Gate(self.robot, description, 0.01)
        self.task_clock = TaskClock(self.clock)
        self.context = Context(
            robot=self.robot,
            model=self.controller.model,
            clock=self.task_clock,
            vision=Vision(Eyelid(self.robot), detector()),
            now=Now(state=self.robot.read()),
            around=Around(fixtures=load_world_model(self.world).fixtures),
        )
        self._ticks = 0

    def tick(self, leaf: Leaf | None) -> None:
        state = self.robot.read()
        self.context.begin_tick(state)
        intent = None if leaf is None else intent_of(leaf, self.context)
        self.step(state, intent and intent.goal)

    def pursue(self, goal: MotionGoal) -> StepReport:
        """A tick without a leaf, towards a goal."""
        state = self.robot.read()
        self.context.begin_tick(state)
        self.context.now.intend(Intent(goal, Running("nobody")))
        return self.step(state, goal)

    def step(self, state: RobotState, goal: MotionGoal | None) -> StepReport:
        """The end of a tick: the controller goes for a goal in odometry."""
        here = self.context.localisation
        return self._step(state, here.mTb, here.on_map(goal), self.context.end_tick)

    def _step(self, state: RobotState, mTb, goal, told=lambda report: None) -> StepReport:
        around = self.context.surroundings
        here = KinematicState(mTb, state.q)
        command, report = self.controller.step(here, goal, self.gate.applied, around)
        self.gate.send(command, state, self.clock.now())
        told(report)
        self._ticks += 1
        self.clock.sleep_until(self._ticks * 0.01)
        return report

    def grip(self, width: float, force: float = 20.0) -> None:
        """Set the fingers moving as a leaf does, and wait for them."""
        self.context.read(self.robot.read())
        self.context.log.gripped(width)
        self.robot.grip(width, force)
        self.run_for(None, 1.0)

    def reach(self, goal: PoseGoal) -> None:
        """Bring the hand to a goal without any leaf, down to what it stands on if need be."""
        goal = replace(goal, hand_may_touch=True)
        for _ in range(1500):
            state = self.robot.read()
            if self._step(state, state.oTb, goal).arrived:
                return
        raise AssertionError("not there")

    def reach_over(self, oTe: SE3) -> None:
        """Bring the hand somewhere and let it come to rest."""
        self.reach(PoseGoal(target=oTe))
        self.run_for(None, 0.5)

    def run(self, leaf: Leaf, seconds: float = 30.0) -> Status:
        """Tick until the leaf ends; RUNNING if it does not in time."""
        for _ in range(round(seconds * 100)):
            self.tick(leaf)
            if leaf.status is not Status.RUNNING:
                break
        return leaf.status

    def run_into(self, leaf: Leaf, phase: str) -> None:
        """Tick until the leaf is in a phase."""
        self.tick(leaf)
        while leaf.phase != phase:
            assert leaf.status is Status.RUNNING, leaf.feedback_message
            self.tick(leaf)

    def run_for(self, leaf: Leaf | None, seconds: float) -> None:
        for _ in range(round(seconds * 100)):
            self.tick(leaf)

    @property
    def speed(self) -> float:
        state = self.robot.read()
        return float(max(np.abs(state.qd).max(), np.abs(state.base_twist).max()))


@cache
def _reached(x: float, y: float, z: float, yaw: float) -> tuple[np.ndarray, SE3]:
    """Joint angles and pose of the base with the hand there over a bare table; found once."""
    harness = Harness(table_world())
    harness.reach(
        PoseGoal(target=looking_down(x, y, z, yaw), position_tolerance=0.002, straight=True)
    )
    harness.run_for(None, 0.5)
    state = harness.robot.read()
    return state.q, state.oTb


def with_the_hand_at(world: World, x: float, y: float, z: float, yaw: float = 0.0) -> Harness:
    """The robot begins there, at rest: to drive there takes most of the time of a test."""
    return Harness(world, at=_reached(x, y, z, yaw))


def over_the_table(*objects: SimObject) -> Harness:
    """The hand 0.35 m above the table, looking down on it."""
    return with_the_hand_at(table_world(*objects), 0.68, 0.0, TABLE_TOP + 0.35)


def held_block(thing: SimObject | None = None) -> Harness:
    """The hand holds a block, low over the table."""
    harness = with_the_hand_at(table_world(thing or block()), 0.7, 0.0, TABLE_TOP + 0.03, np.pi / 2)
    harness.grip(0.0)
    assert harness.world.held is not None
    harness.context.log.grip_height = 0.03
    harness.context.log.attempt(TaskTime(0.0), TaskTime(1.0))
    return harness


def place(harness: Harness, on: Region = FAR) -> Place:
    return Place("place", harness.context, on=on, pitch_m=0.13)
