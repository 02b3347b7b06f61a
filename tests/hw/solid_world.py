"""Test stand of collisions: a simulated robot, its world and its clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from pinocchio import SE3

from controller import Command, robot_model
from hw import ComposedRobot, SimClock, find_world
from hw.sim import SimObject, Walker, World, kinematic_robot, simulated_robot
from robots import Box, Geom, Plane, load_robot

FLOOR = Geom(Plane(), SE3.Identity(), "floor")
STILL = np.zeros(3)


def box(name: str, centre: Sequence[float], half: tuple[float, float, float]) -> Geom:
    return Geom(Box(half), SE3(np.eye(3), np.array(centre, dtype=float)), name)


def cube(name: str, centre: Sequence[float], half: float = 0.02) -> SimObject:
    parts = (Geom(Box((half, half, half)), SE3.Identity(), name),)
    return SimObject(
        name=name, parts=parts, mass=0.1, pose=SE3(np.eye(3), np.array(centre, dtype=float))
    )


def turning(joint: int, speed: float) -> np.ndarray:
    """(7,) velocity of one joint, counted from 1 [rad/s]."""
    qd = np.zeros(7)
    qd[joint - 1] = speed
    return qd


TOOL = robot_model("frankie").end_effector(SE3.Identity(), load_robot("frankie").arm.ready)
"""The end effector of the robot at its start."""


def box_at_the_hand(mass: float = 0.3) -> tuple[Geom, SimObject]:
    """A pillar, and on it a box between the open fingers."""
    half = (0.03, 0.02, 0.03)
    x, y, z = TOOL.translation
    top = z + 0.005 - half[2]
    parts = (Geom(Box(half), SE3.Identity(), "box"),)
    here = SE3(TOOL.rotation, np.array([x, y, top + half[2]]))
    thing = SimObject(name="box", parts=parts, mass=mass, friction=0.5, pose=here)
    return box("pillar", (x, y, top / 2.0), (0.05, 0.05, top / 2.0)), thing


def physical(*fixtures: Geom, **rest) -> Solid:
    """In the physical world."""

    def make(*args) -> ComposedRobot:
        return simulated_robot(find_world("physics").body(), *args)

    return Solid(*fixtures, make=make, **rest)


class Solid:
    def __init__(
        self,
        *fixtures: Geom,
        objects: Sequence[SimObject] = (),
        walkers: Sequence[Walker] = (),
        robot: str = "frankie",
        world: World | None = None,
        make: Callable[..., ComposedRobot] = kinematic_robot,
    ) -> None:
        self.clock = SimClock()
        self.world = world or World([FLOOR, *fixtures], objects, walkers)
        self.robot = make(load_robot(robot), self.world, self.clock)
        self.body = self.robot._arm.body
        self.model = robot_model(robot)

    def drive(self, twist: Sequence[float] = STILL, qd: np.ndarray | None = None, s: float = 1.0):
        """Command the same velocities for a while; returns the faults that there are then."""
        command = Command(
            base_twist=np.array(twist, dtype=float), qd=np.zeros(7) if qd is None else qd
        )
        for _ in range(round(s * 100)):
            self.robot.send(command)
            self.clock.sleep_until(self.clock.now() + 0.01)
        return self.faults

    def rise(self, speed: float = 0.15, s: float = 1.0) -> None:
        """Move the hand straight up [m/s]."""
        up = np.array([0.0, 0.0, speed, 0.0, 0.0, 0.0])
        for _ in range(round(s * 100)):
            J = self.model.kinematics(self.robot.read().q).J[:, self.model.n_base :]
            self.drive(qd=np.linalg.pinv(J) @ up, s=0.01)

    @property
    def faults(self) -> list[tuple[str, str]]:
        """Kind and text of each."""
        return [(fault.kind.value, fault.text) for fault in self.robot.read().faults]

    @property
    def touches(self) -> list[str]:
        return [touch.text for touch in self.world.touches]

    def link(self, number: int) -> np.ndarray:
        """(3,) origin of a link's frame in the world; the foot of the arm is link 0."""
        state = self.robot.read()
        return self.model.link_poses(state.oTb, state.q)[number].translation

    @property
    def x(self) -> float:
        return float(self.robot.read().oTb.translation[0])
