"""Docking: the base drives straight into its place, the arm already in its final posture.

So a hand gets between boards or among objects on a table. At the dock, where the straight line
begins, the arm has room to unfold.
"""

from collections.abc import Generator
from math import ceil, cos, hypot, sin

import numpy as np

from controller.command import Array
from controller.floor.base_drive import Pose2D
from controller.model import RobotModel
from controller.stance.free_space import FreeSpace, se3_of
from controller.stance.stance import Stance

ROOM = 0.05  # obstacles nearer than this to the arm are in its way [m]
YIELD = 0.005  # tolerance when distances are compared with that at the stance [m]
_STEP = 0.1  # distance between the places that are checked [m]
_LONGEST = 1.0  # longest line [m]
_LEVEL = 0.3  # least horizontal part of a hand's direction that gives the direction of a line
_UNFOLDING = 0.25  # largest joint difference between checked postures of an unfolding arm [rad]
_UNFOLDING_ROOM = 0.04  # clearance of the arm while it unfolds at the dock [m]


def with_docking(
    model: RobotModel, space: FreeSpace, base: Pose2D, stance: Stance
) -> Generator[None, None, Stance]:
    """A stance at a base pose with its dock, if there is one; found in bounded pieces of work."""
    start = transport_posture(model.description.arm.ready, stance.q)
    room = space.nearest(se3_of(base), stance.q, space.parts, ROOM).distance
    (stands,) = space.floor.stands_free(np.array([base])).tolist()
    lines = _lines(model, stance)
    for distance in np.arange(_STEP, _LONGEST + _STEP, _STEP).tolist():
        for line in list(lines):
            yield
            dock = -distance * line[0], -distance * line[1]
            place = moved(base, dock)
            (there,) = space.floor.stands_free(np.array([place])).tolist()
            near = space.nearest(se3_of(place), stance.q, space.parts, ROOM).distance
            if there < min(ROOM, stands) - YIELD or near < room - YIELD:
                lines.remove(line)
            elif near >= ROOM:
                yield
                if unfolds(space, place, start, stance.q, _UNFOLDING_ROOM):
                    return stance._replace(dock=dock)
    return stance


def _lines(model: RobotModel, stance: Stance) -> list[tuple[float, float]]:
    """Directions of straight lines in the base frame: as the hand points, and ahead."""
    ahead = (-1.0 if stance.reverse else 1.0), 0.0
    x, y, _ = stance.bTe.rotation[:, 2].tolist()
    level = hypot(x, y)
    if model.n_base == 2 or level < _LEVEL:
        return [ahead]
    return [(x / level, y / level), ahead]


def transport_posture(ready: Array, aim: Array) -> Array:
    """The posture (j,) for transport: ready, with the hand turned as in posture `aim`."""
    return np.append(ready[:-1], aim[-1])


def unfolds(space: FreeSpace, base: Pose2D, start: Array, aim: Array, room: float) -> bool:
    """Whether the arm keeps a distance `room` [m] on its straight joint path, its end left out."""
    here, way = se3_of(base), aim - start
    steps = max(2, ceil(np.abs(way).max() / _UNFOLDING))
    postures = start + np.linspace(0.0, 1.0, steps, endpoint=False)[1:, None] * way
    return all(
        space.nearest(here, posture, space.parts, room).distance >= room for posture in postures
    )


def moved(base: Pose2D, by: tuple[float, float]) -> Pose2D:
    """A base pose moved in its own frame [m]."""
    c, s = cos(base.heading), sin(base.heading)
    return Pose2D(base.x + c * by[0] - s * by[1], base.y + s * by[0] + c * by[1], base.heading)
