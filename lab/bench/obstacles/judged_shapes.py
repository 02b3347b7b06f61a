"""The shapes of a robot along a motion, independent of those of the controller.

Capsules of the arm with the radii of the manufacturer's self-collision model, or of the file of
another arm; boxes of the base, the hand with open fingers and the camera.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from config.planar import about_z
from lab.bench.contacts import CAPSULES, HAND, capsule_on_link, is_panda
from lab.bench.obstacles.convex_distances import Placed
from robots import Box, Capsule, RobotDescription, Shape


class _Part(NamedTuple):
    name: str
    link: int  # 0 is the foot of the arm, 1 to j its links, -1 the base
    shape: Shape
    placement: SE3  # on its link


_ON_BASE = -1


def _parts(robot: RobotDescription) -> Iterator[_Part]:
    length, width, height = robot.base.size
    middle = SE3(np.eye(3), np.array([0.0, 0.0, height / 2.0]))
    yield _Part("base", _ON_BASE, Box((length / 2.0, width / 2.0, height / 2.0)), middle)
    last = len(robot.arm.joints)
    for link, shapes in enumerate(() if is_panda(robot) else robot.arm.collision):
        yield from (_Part(f"link{link}", link, one.shape, one.pose) for one in shapes)
    for capsule in CAPSULES if is_panda(robot) else ():
        if capsule.link != HAND:
            radius, axis, placement = capsule_on_link(capsule)
            shape = Capsule(radius, axis / 2.0)
            yield _Part(f"link{capsule.link}", capsule.link, shape, placement)
    hand, lTe = robot.gripper, robot.arm.lTh * robot.gripper.hTe
    yield _Part("hand", last, hand.palm.shape, lTe * hand.palm.pose)
    for geom in (hand.finger, hand.pad):
        for side in (1.0, -1.0):
            x, y, z = geom.pose.translation
            place = np.array([x, side * (y + hand.opening / 2.0), z])
            yield _Part("fingers", last, geom.shape, lTe * SE3(geom.pose.rotation, place))
    camera = robot.camera
    yield _Part("camera", last, camera.body.shape, lTe * camera.eTc * camera.body.pose)


class RobotShapes:
    """The shapes of one robot."""

    def __init__(self, robot: RobotDescription) -> None:
        self._robot = robot
        self._parts = tuple(_parts(robot))

    def placed(self, base: Array, q: Array) -> list[tuple[str, Placed]]:
        """All parts with their names, in k poses.

        `base` is (k, 3) x, y [m] and heading [rad], `q` (k, j) joint positions [rad].
        """
        frames = self._frames(base, q)
        found = []
        for part in self._parts:
            R, p = frames[part.link]
            found.append((part.name, Placed(part.shape, *_on(R, p, part.placement))))
        return found

    def tool(self, base: Array, q: Array) -> Placed:
        """The end effector in k poses, as a point."""
        R, p = self._frames(base, q)[q.shape[1]]
        lTe = self._robot.arm.lTh * self._robot.gripper.hTe
        return Placed(Box((0.0, 0.0, 0.0)), *_on(R, p, lTe))

    def _frames(self, base: Array, q: Array) -> dict[int, tuple[Array, Array]]:
        R = about_z(base[:, 2])
        p = np.column_stack([base[:, :2], np.zeros(len(base))])
        frames = {_ON_BASE: (R, p)}
        R, p = _on(R, p, self._robot.bTa)
        frames[0] = (R, p)
        for joint, placement in enumerate(self._robot.arm.joints):
            R, p = _on(R, p, placement)
            if self._robot.arm.slides[joint]:
                p = p + q[:, joint, None] * R[..., 2]
            else:
                R = R @ about_z(q[:, joint])
            frames[joint + 1] = (R, p)
        return frames


def _on(R: Array, p: Array, placement: SE3) -> tuple[Array, Array]:
    return R @ placement.rotation, p + R @ placement.translation
