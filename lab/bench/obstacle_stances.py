"""Stances to draw goals from: postures of the arm, and the base where the tool is at a point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from controller import Array, RobotModel
from lab.bench.contacts import ContactChecker
from lab.bench.obstacle_body import Body

_DRAWN = 60_000
_SEED = 7
_MARGIN = 0.15
"""Postures keep this distance from every joint limit [rad]."""
_MAX_BEARING = 1.0
"""Largest bearing of the tool seen from the foot of the arm [rad]."""
_LOWEST = 0.10
"""Least height of the tool and of the flange [m]."""
_DOWN = -0.9
"""The approach of a hand that points down goes down at least by this [cosine]."""
_SLANTED = (-0.77, 0.2)
"""The same of a hand that is horizontal or slanted."""
_SAME_HEIGHT = 0.03
"""A posture suits a point whose height differs by no more than this [m]."""


class Stance(NamedTuple):
    """Where the robot stands with its tool at a goal."""

    base: Array
    """(3,) x, y [m] and heading [rad]."""
    q: Array
    """(7,) joint positions [rad]."""


class Postures(NamedTuple):
    """N postures in which the arm does not touch itself, the base or the floor."""

    q: Array
    """(N, 7) [rad]."""
    tools: Array
    """(N, 3) the tool in the base frame [m]."""
    approach: Array
    """(N, 3) where the hand points to, in the base frame."""

    def chosen(self, which: npt.NDArray[np.bool_]) -> Postures:
        """Some of them."""
        return Postures(*(values[which] for values in self))

    @property
    def down(self) -> Postures:
        """Those with the hand down."""
        return self.chosen(self.approach[:, 2] < _DOWN)

    @property
    def slanted(self) -> Postures:
        """Those with the hand horizontal or slanted."""
        low, high = _SLANTED
        return self.chosen((low < self.approach[:, 2]) & (self.approach[:, 2] < high))


def draw_postures(model: RobotModel, checker: ContactChecker) -> Postures:
    """Postures of one robot, always the same."""
    rng, limits = np.random.default_rng(_SEED), model.limits
    q = rng.uniform(limits.q_min + _MARGIN, limits.q_max - _MARGIN, (_DRAWN, len(limits.q_min)))
    tool = Body(model.description).tool(np.zeros((_DRAWN, 3)), q)
    approach, place = tool.rotations[:, :, 2], tool.positions
    flange = place - approach * float(model.description.gripper.hTe.translation[2])
    foot = model.description.bTa.translation
    bearing = np.arctan2(place[:, 1] - foot[1], place[:, 0] - foot[0])
    good = (np.abs(bearing) < _MAX_BEARING) & (place[:, 2] > _LOWEST) & (flange[:, 2] > _LOWEST)
    found = Postures(q[good], place[good], approach[good])
    return found.chosen(np.array([not checker(posture).any for posture in found.q]))


def stance_at(
    rng: np.random.Generator, postures: Postures, point: Array, yaw: float | None = None
) -> Stance | None:
    """A random stance with the tool above or below a point (3,), hardly; None if there is none.

    Args:
        rng: draws the posture, and the heading of the base if it is free.
        postures: to choose from.
        point: for the tool, in the world [m]; the height is met up to 3 cm.
        yaw: horizontal direction that the hand points to [rad]; None is any.
    """
    suited = np.flatnonzero(np.abs(postures.tools[:, 2] - point[2]) < _SAME_HEIGHT)
    if not len(suited):
        return None
    number = rng.choice(suited)
    tool, (ax, ay, _) = postures.tools[number], postures.approach[number]
    heading = rng.uniform(-np.pi, np.pi) if yaw is None else yaw - np.arctan2(ay, ax)
    c, s = np.cos(heading), np.sin(heading)
    place = point[:2] - np.array([c * tool[0] - s * tool[1], s * tool[0] + c * tool[1]])
    return Stance(np.array([*place, heading]), postures.q[number])
