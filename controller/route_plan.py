"""Planning the way of the base to a pose: out of its place, along the cheapest way, and in."""

from __future__ import annotations

from math import cos, pi, sin
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from controller.base_drive import Pose2D, wrap
from controller.command import Array
from controller.floor_map import FloorMap
from controller.model import RobotModel
from controller.path import SPACING, Path, paths_along, pull_straight

CLEARANCE = 0.04
"""Distance that the base keeps where it has the choice [m]."""
_LONGEST_ESCAPE = 1.6
"""A place to turn is looked for on straights as long as this [m]."""
_RUN_UP = 0.25
"""How much farther than needed the base goes straight in, where it can [m]."""


class Leg(NamedTuple):
    """A piece of the way that is driven without changing direction."""

    path: Path
    backwards: bool
    headings: Array
    """(N,) of the base on it [rad]."""
    narrow: npt.NDArray[np.bool_]
    """(N,) whether the base cannot turn there."""


class Planner:
    """Plans one way.

    Args:
        model: the robot.
        room: what stands around.
        reverse: drive backwards; what is called forwards below is then backwards.
    """

    def __init__(self, model: RobotModel, room: FloorMap, reverse: bool) -> None:
        self._room = room
        self._holonomic = model.n_base == 3
        self._flip = pi if reverse and not self._holonomic else 0.0
        limits = model.limits
        speeds = float(limits.base_twist[0]), limits.base_reverse
        self._ahead, self._back = speeds[::-1] if self._flip else speeds
        self._turn_rate = float(limits.base_twist[2])

    def legs(self, start: Pose2D, goal: Pose2D) -> list[Leg]:
        """The legs of the way; none if there is no way."""
        room = self._room
        a, b = self._facing(start), self._facing(goal)
        ins = self._straights(b, (-1, 1))
        outs = self._straights(a, (1, -1))
        for into in ins:
            gate = _moved(b, into)
            field = room.field((gate.x, gate.y))
            starts = np.array([_moved(a, out)[:2] for out in outs])
            costs = field.at(starts)
            if not np.isfinite(costs).any():
                continue
            times = costs / self._ahead + [
                abs(s) / (self._ahead if s > 0 else self._back) for s in outs
            ]
            out = outs[int(times.argmin())]
            door = _moved(a, out)
            way = field.way_from((door.x, door.y))
            if way is None:
                continue
            line = pull_straight(way, room.clearance, room.turning)
            return self._along(a, out, line, into, b)
        return []

    def _facing(self, pose: Pose2D) -> Pose2D:
        return Pose2D(pose.x, pose.y, wrap(pose.heading + self._flip))

    def _straights(self, pose: Pose2D, signs: tuple[int, int]) -> list[float]:
        """Signed lengths of straights from a pose to places where the base can turn, best first.

        Without any, it stays where it is.
        """
        room = self._room
        if room.clearance(np.array([pose[:2]]))[0] >= room.turning - 0.02:
            return [0.0]
        found = []
        for sign in signs:
            lengths = sign * np.arange(0.0, _LONGEST_ESCAPE, SPACING)
            poses = np.array([_moved(pose, length) for length in lengths.tolist()])
            poses[:, 2] += self._flip
            free = room.stands_free(poses)
            touches = np.flatnonzero(free < min(CLEARANCE, free[0]) - 0.005)
            end = int(touches[0]) if len(touches) else len(lengths)
            turns = np.flatnonzero(room.clearance(poses[:end, :2]) >= room.turning)
            if len(turns):
                first = int(turns[0])
                run_up = [int(t) for t in turns if t <= first + round(_RUN_UP / SPACING)]
                found.append(float(lengths[run_up[-1] if signs[0] < 0 and sign < 0 else first]))
        return found or [0.0]

    def _along(self, a: Pose2D, out: float, line: Array, into: float, b: Pose2D) -> list[Leg]:
        legs: list[Leg] = []
        if out < 0.0:
            legs += self._driven(np.array([a[:2], line[0]]), backwards=True)
        elif out > 0.0:
            line = np.concatenate([[a[:2]], line])
        if into < 0.0:
            line = np.concatenate([line, [b[:2]]])
        legs += self._driven(line, backwards=False)
        if into > 0.0:
            legs += self._driven(np.array([line[-1], b[:2]]), backwards=True)
        return legs if not self._holonomic else [self._turned(leg, a, b) for leg in legs]

    def _driven(self, line: Array, *, backwards: bool) -> list[Leg]:
        flip = pi if backwards else 0.0

        def is_free(poses: Array) -> bool:
            turned = poses + np.array([0.0, 0.0, flip + self._flip])
            return bool((self._room.stands_free(turned) >= CLEARANCE).all())

        speed = self._back if backwards else self._ahead
        legs = []
        for path in paths_along(line, is_free, speed, self._turn_rate):
            headings = path.points[:, 2] + flip + self._flip
            narrow = self._room.clearance(path.points[:, :2]) < self._room.turning - 0.02
            legs.append(Leg(path, backwards, headings, narrow))
        return legs

    def _turned(self, leg: Leg, a: Pose2D, b: Pose2D) -> Leg:
        """The leg with the headings of a base that turns where it likes."""
        headings = np.full(len(leg.headings), b.heading)
        room, narrow = self._room, leg.narrow
        ahead = b.heading
        for k in range(len(headings) - 1, -1, -1):
            if narrow[k]:
                x, y, way = leg.path.points[k].tolist()
                wishes = [ahead, a.heading, b.heading, way, way + pi]
                free = room.stands_free(np.array([(x, y, wish) for wish in wishes]))
                good = [w for w, f in zip(wishes, free.tolist(), strict=True) if f >= CLEARANCE / 2]
                ahead = good[0] if good else wishes[int(free.argmax())]
            headings[k] = ahead
        return leg._replace(headings=headings)


def _moved(pose: Pose2D, length: float) -> Pose2D:
    """A pose this far along its heading."""
    return Pose2D(
        pose.x + length * cos(pose.heading), pose.y + length * sin(pose.heading), pose.heading
    )
