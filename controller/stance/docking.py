"""Docking: the base drives straight into its place, the arm already in its final posture.

So a hand gets between boards or among objects on a table. At the dock, where the straight line
begins, the arm has room to unfold.
"""

from collections.abc import Generator
from math import ceil

import numpy as np

from config.arrays import Array
from config.planar import Pose2D
from controller.model import RobotModel
from controller.stance.free_space import FreeSpace
from controller.stance.stance import Stance

ROOM = 0.05  # obstacles nearer than this to the arm are in its way [m]
YIELD = 0.005  # tolerance when distances are compared with that at the stance [m]
_STEP = 0.1  # distance between the places that are checked [m]
_LONGEST = 1.0  # longest line [m]
_UNFOLDING = 0.25  # largest joint difference between checked postures of an unfolding arm [rad]
_UNFOLDING_ROOM = 0.04  # clearance of the arm while it unfolds at the dock [m]


def with_docking(
    model: RobotModel, space: FreeSpace, base: Pose2D, stance: Stance
) -> Generator[None, None, Stance]:
    """A stance at a base pose with its dock, if there is one; found in bounded pieces of work."""
    start = transport_posture(model.description.arm.ready, stance.q)
    room = space.room(base, stance.q, ROOM)
    (stands,) = space.floor.stands_free(base).tolist()
    for distance in np.arange(_STEP, _LONGEST + _STEP, _STEP).tolist():
        yield
        dock = distance if stance.reverse else -distance
        place = base.moved(dock)
        (there,) = space.floor.stands_free(place).tolist()
        near = space.room(place, stance.q, ROOM)
        if there < min(ROOM, stands) - YIELD or near < room - YIELD:
            break
        if near >= ROOM:
            yield
            if unfolds(space, place, start, stance.q, _UNFOLDING_ROOM):
                return stance._replace(dock=dock)
    return stance


def transport_posture(ready: Array, aim: Array) -> Array:
    """The posture (j,) for transport: ready, with the hand turned as in posture `aim`."""
    return np.append(ready[:-1], aim[-1])


def unfolds(space: FreeSpace, base: Pose2D, start: Array, aim: Array, room: float) -> bool:
    """Whether the arm keeps a distance `room` [m] on its straight joint path, its end left out."""
    way = aim - start
    steps = max(2, ceil(np.abs(way).max() / _UNFOLDING))
    postures = start + np.linspace(0.0, 1.0, steps, endpoint=False)[1:, None] * way
    return all(space.room(base, posture, room) >= room for posture in postures)
