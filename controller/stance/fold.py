"""The fold to a stance: the straight path of the arm in joint space while the base drives there."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from controller.collision import SelfCollision
from controller.floor import Pose2D
from controller.stance.free_space import ARM, HAND, FreeSpace, se3_of
from controller.stance.stance import Stance
from controller.stance.stance_cost import Start

_SAMPLES = np.linspace(0.0, 1.0, 17)[1:, None]
"""Where it is checked for contact of the robot with itself and the floor."""
_HERE = (0.3, 0.6)
"""Where it is checked for contact with fixtures, the base where it stands now ..."""
_THERE = ((0.4, 0.8), (0.4, 1.0), (0.2, 1.0))
"""... and so far before the stance [m]: the arm is ready before the base arrives."""


def room_missing(
    collision: SelfCollision,
    space: FreeSpace | None,
    start: Start,
    base: Pose2D,
    stance: Stance,
    clearance: float,
) -> float:
    """How much the fold to a stance comes too near to anything [m].

    Of what is missing to fixtures no more than `clearance` counts.

    Args:
        collision: the robot's own shapes.
        space: what stands around; None on an open floor.
        start: where the robot sets out from.
        base: where it will stand.
        stance: how.
        clearance: the distance to keep [m].
    """
    way = stance.q - start.q
    least = min(collision.clearance(posture) for posture in start.q + _SAMPLES * way)
    missing = max(0.0, clearance - least)
    if space is None:
        return missing
    here, whole = se3_of(start.wTb), ARM + HAND
    now = space.nearest(here, start.q, whole, clearance).distance  # it cannot do better than now
    first = min(space.nearest(here, start.q + k * way, whole, clearance).distance for k in _HERE)
    lacking = max(0.0, now - max(0.0, first))
    forward = -1.0 if stance.reverse else 1.0
    for before, share in _THERE:
        x = base.x - forward * before * cos(base.heading)
        y = base.y - forward * before * sin(base.heading)
        there = se3_of(Pose2D(x, y, base.heading))
        near = space.nearest(there, start.q + share * way, whole, clearance)
        lacking = max(lacking, clearance - max(0.0, near.distance))
    return missing + lacking
