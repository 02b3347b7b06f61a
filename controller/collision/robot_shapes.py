"""Collision shapes of the robot, and edges of boxes around it.

The arm is made of capsules or hulls, the base of a box with a capsule in each corner, the camera of
a box.

The nearest points of two faces jump from one edge to another while the base turns. So edges are
shapes of their own: without their distances the base would turn into the wall that it faces.
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from pinocchio import SE3

from controller.model import RobotModel
from robots import Box, Capsule, Geom, Plane

_CORNER, _EDGE = 0.05, 1e-3  # radii of the capsules in corners of the base and in edges [m]
_UPRIGHT = 0.99  # cosine of the largest tilt of an upright edge


class Part(NamedTuple):
    """A shape of the robot."""

    link: int  # -1 the base, 0 the arm's foot, 1 to j its links
    geom: Geom  # in the frame of the link; of the base and the foot in b


def held_parts(model: RobotModel, held: Sequence[Geom]) -> list[Part]:
    """The shapes of held objects, which are in e."""
    lTe = model.description.arm.lTh * model.description.gripper.hTe
    return [Part(model.n_arm, shape.moved(lTe)) for shape in held]


def robot_parts(model: RobotModel) -> dict[str, list[Part]]:
    """The shapes of robot and floor by part names, with an empty hand."""
    robot, last = model.description, model.n_arm
    lTe = robot.arm.lTh * robot.gripper.hTe
    parts = {
        f"link{link}": [Part(link, shape if link else shape.moved(robot.bTa)) for shape in shapes]
        for link, shapes in enumerate(robot.arm.collision)
    }
    parts["hand"] = [Part(last, shape.moved(robot.arm.lTh)) for shape in robot.gripper.collision]
    # The capsules around the hand leave its corners free; against itself they are enough.
    parts["palm"] = [Part(last, robot.gripper.palm.moved(lTe))]
    parts["camera"] = [Part(last, robot.camera.body.moved(lTe * robot.camera.eTc))]
    parts["held"] = []
    length, width, height = robot.base.size
    half = (length / 2.0, width / 2.0, height / 2.0)
    middle = SE3(np.eye(3), np.array([0.0, 0.0, half[2]]))
    base = [Geom(Box(half), SE3.Identity()), *_edges(half, _CORNER)]
    parts["base"] = [Part(-1, shape.moved(middle)) for shape in base]
    parts["floor"] = [Part(-1, Geom(Plane(), SE3.Identity(), "floor"))]
    return parts


def upright_edges(fixture: Geom) -> list[Geom]:
    """Thin capsules in the upright edges of a box, with its name; none for other shapes."""
    if not isinstance(fixture.shape, Box) or abs(fixture.pose.rotation[2, 2]) < _UPRIGHT:
        return []
    return [edge.moved(fixture.pose) for edge in _edges(fixture.shape.half, _EDGE, fixture.name)]


def _edges(half: tuple[float, float, float], radius: float, name: str = "") -> list[Geom]:
    """Capsules in the four edges of a box along its z."""
    x, y, z = half
    capsule = Capsule(radius, max(z - radius, 0.0))
    return [
        Geom(capsule, SE3(np.eye(3), np.array([i * (x - radius), j * (y - radius), 0.0])), name)
        for i, j in product((-1.0, 1.0), repeat=2)
    ]
