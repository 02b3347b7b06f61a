"""Where the base begins to go straight in, the arm as it will be at the goal.

A hand between boards, or among things on a table, got there along one line: the base goes straight,
and the arm does not move. Where that line begins nothing is near the arm, and it can unfold there.
"""

from __future__ import annotations

from collections.abc import Generator
from math import ceil, cos, hypot, sin

import numpy as np

from controller.command import Array
from controller.floor import Pose2D
from controller.model import RobotModel
from controller.stance.free_space import ARM, HAND, FreeSpace, se3_of
from controller.stance.stance import Stance

ROOM = 0.05
"""What comes nearer than this to the arm is in its way [m]."""
YIELD = 0.005
"""So much less than at the stance does not count as nearer [m]."""
PARTS = (*ARM, *HAND, "palm")
"""What must have room."""
_STEP = 0.1
"""Between the places that are looked at [m]."""
_LONGEST = 1.0
"""No line is longer [m]."""
_LEVEL = 0.3
"""A hand that points down or up does not say where it came from: less of it is horizontal."""
_UNFOLDING = 0.25
"""Between the postures that are looked at while the arm unfolds, in the joint that moves most
[rad]."""
_UNFOLDING_ROOM = 0.04
"""What the arm needs there, where the line begins [m]."""


def with_docking(
    model: RobotModel, space: FreeSpace, base: Pose2D, stance: Stance
) -> Generator[None, None, Stance]:
    """A stance with the place from which the base goes straight in, if there is one.

    It is found in pieces of bounded work.

    Args:
        model: the robot.
        space: what stands around.
        base: where it will stand.
        stance: how.
    """
    start = carried(model.description.arm.ready, stance.q)
    room = space.nearest(se3_of(base), stance.q, PARTS, ROOM).distance
    (stands,) = space.floor.stands_free(np.array([base])).tolist()
    lines = _lines(model, stance)
    for distance in np.arange(_STEP, _LONGEST + _STEP, _STEP).tolist():
        for line in list(lines):
            yield
            dock = -distance * line[0], -distance * line[1]
            place = moved(base, dock)
            (there,) = space.floor.stands_free(np.array([place])).tolist()
            near = space.nearest(se3_of(place), stance.q, PARTS, ROOM).distance
            if there < min(ROOM, stands) - YIELD or near < room - YIELD:
                lines.remove(line)
            elif near >= ROOM:
                yield
                if unfolds(space, place, start, stance.q, _UNFOLDING_ROOM):
                    return stance._replace(dock=dock)
    return stance


def _lines(model: RobotModel, stance: Stance) -> list[tuple[float, float]]:
    """Directions to go straight in to, in the base frame: as the hand points, and ahead."""
    ahead = (-1.0 if stance.reverse else 1.0), 0.0
    x, y, _ = stance.bTe.rotation[:, 2].tolist()
    level = hypot(x, y)
    if model.n_base == 2 or level < _LEVEL:
        return [ahead]
    return [(x / level, y / level), ahead]


def carried(ready: Array, aim: Array) -> Array:
    """The posture (7,) to carry the arm in: ready, the hand already turned as in posture `aim`."""
    return np.append(ready[:-1], aim[-1])


def unfolds(space: FreeSpace, base: Pose2D, start: Array, aim: Array, room: float) -> bool:
    """Whether an arm that goes straight in joint space has so much room [m] all the way.

    Args:
        space: what stands around.
        base: where the base stands.
        start: (7,) where the arm is [rad].
        aim: (7,) where it goes; it is known to have room there [rad].
        room: distance to everything [m].
    """
    here, way = se3_of(base), aim - start
    steps = max(2, ceil(np.abs(way).max() / _UNFOLDING))
    postures = start + np.linspace(0.0, 1.0, steps, endpoint=False)[1:, None] * way
    return all(space.nearest(here, posture, PARTS, room).distance >= room for posture in postures)


def moved(base: Pose2D, by: tuple[float, float]) -> Pose2D:
    """A base pose moved in its own frame [m]."""
    c, s = cos(base.heading), sin(base.heading)
    return Pose2D(base.x + c * by[0] - s * by[1], base.y + s * by[0] + c * by[1], base.heading)
