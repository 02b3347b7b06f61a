"""Plans the path of a base: straight out of its place, through the room, and straight in."""

from collections.abc import Iterator
from itertools import pairwise
from math import hypot, pi
from typing import NamedTuple

import numpy as np

from config.arrays import Array, Mask
from config.planar import Pose2D, wrap
from controller.floor.floor_map import FloorMap
from controller.floor.path import SPACING, Path, path_at, paths_along, pull_straight
from controller.model import RobotModel

CLEARANCE = 0.04  # distance to obstacles that the base keeps where it can [m]
_LONGEST_ESCAPE = 1.6  # longest straight line out of or into a place [m]
_LEAST = 0.01  # least distance of a path to obstacles [m] ...
_NO_CHOICE = 0.15  # ... except this near to its ends [m]
_NO_NEARER = 0.005  # by which an arc may be nearer to obstacles than its ends [m]
_TURNS = np.deg2rad([10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0]).tolist()
"""Turns on the spot that may come before a straight line out of a place [rad]."""
_LESS_TO_TURN = 0.02  # less room is enough for a base that has only to turn [m]
_RUN_UP = 0.25  # extra length of a straight line into a place, where there is room [m]


class Leg(NamedTuple):
    """A part of the path that is driven in one direction."""

    path: Path
    backwards: bool
    headings: Array  # (N,) of the base [rad]
    narrow: Mask  # (N,) whether the base cannot turn there


def duration(legs: list[Leg], start: Pose2D, goal: Pose2D, turn_rate: float) -> float:
    """Time to drive legs with turns on the spot between them [s]."""
    driving = sum(float(leg.path.times[0]) for leg in legs)
    return driving + sum(turns(legs, start, goal)) / turn_rate


def turns(legs: list[Leg], start: Pose2D, goal: Pose2D) -> list[float]:
    """Turns on the spot before every leg, and after the last [rad]."""
    come = [start.heading, *(float(leg.headings[-1]) for leg in legs)]
    go = [*(float(leg.headings[0]) for leg in legs), goal.heading]
    return [abs(wrap(after - before)) for before, after in zip(come, go, strict=True)]


class Planner:
    """Plans one path; with `reverse`, forwards below means backwards."""

    def __init__(self, model: RobotModel, room: FloorMap, reverse: bool) -> None:
        self._room = room
        self._holonomic = model.n_base == 3
        self._flip = pi if reverse and not self._holonomic else 0.0
        limits = model.limits
        speeds = float(limits.base_twist[0]), limits.base_reverse
        self._ahead, self._back = speeds[::-1] if self._flip else speeds
        self._turn_rate = float(limits.base_twist[2])
        self._turns_from = room.turning  # distance of obstacles from which a base can turn [m]

    def search(self, start: Pose2D, goal: Pose2D) -> Iterator[list[Leg] | None]:
        """Yields None after every bounded piece of work, and the legs at the end.

        There are no legs if there is no path.
        """
        b = self._facing(goal)
        only_turns = hypot(goal.x - start.x, goal.y - start.y) < SPACING
        self._turns_from = self._room.turning - (_LESS_TO_TURN if only_turns else 0.0)
        a, outs = self._way_out(self._facing(start))
        widest: tuple[float, list[Leg]] = (-np.inf, [])
        for into in self._straights(b, (-1, 1)) or [0.0]:
            yield None
            gate = b.moved(into)
            field = self._room.field((gate.x, gate.y))
            starts = np.array([a.moved(out)[:2] for out in outs])
            times = field.at(starts) / self._ahead
            times += [abs(s) / (self._ahead if s > 0 else self._back) for s in outs]
            out = outs[int(times.argmin())]
            way = field.way_from(a.moved(out)[:2])
            if way is None:
                continue
            yield None
            line = pull_straight(way, self._room.clearance, self._room.turning)
            yield None
            ways = [self._along(a, out, line, into, b)]
            if not self._holonomic:
                yield None
                ways.append(self._along(a, out, line, into, b, backwards=True))
            ways.sort(key=lambda legs: duration(legs, start, goal, self._turn_rate))
            for legs in ways:
                yield None
                widest = max(widest, (self._clearance(legs), legs), key=lambda found: found[0])
                if widest[0] >= _LEAST:
                    yield legs
                    return
        yield widest[1]

    def _clearance(self, legs: list[Leg]) -> float:
        """Least clearance on legs and turns on the spot [m]."""
        poses = [np.column_stack([leg.path.points[:, :2], leg.headings]) for leg in legs]
        end = poses[-1][-1, :2]
        for before, after in list(pairwise(poses)):
            turn = wrap(after[0, 2] - before[-1, 2])
            headings = before[-1, 2] + np.linspace(0.0, turn, 9)
            poses.append(np.column_stack([np.tile(after[0, :2], (9, 1)), headings]))
        every = np.concatenate(poses)
        clearances = self._room.stands_free(every)
        # Start and goal are given.
        ends = np.array([every[0, :2], end])
        away = np.linalg.norm(every[:, None, :2] - ends, axis=2).min(axis=1)
        clearances[away < _NO_CHOICE] = CLEARANCE
        return float(clearances.min())

    def _facing(self, pose: Pose2D) -> Pose2D:
        return Pose2D(pose.x, pose.y, wrap(pose.heading + self._flip))

    def _way_out(self, pose: Pose2D) -> tuple[Pose2D, list[float]]:
        """The pose to leave from, after a turn on the spot where that is needed, and `_straights`.

        A base that stands along furniture has to turn away from it first.
        """
        if found := self._straights(pose, (1, -1)):
            return pose, found
        for sign in (1, -1):
            turned = [pose._replace(heading=pose.heading + sign * turn) for turn in _TURNS]
            swept = np.array([pose, *turned])
            swept[:, 2] += self._flip
            free = self._room.stands_free(swept)
            blocked = np.flatnonzero(free < min(CLEARANCE, free[0]) - _NO_NEARER)
            for other in turned[: int(blocked[0]) - 1 if len(blocked) else None]:
                if found := self._straights(other, (1, -1)):
                    return other, found
        return pose, [0.0]

    def _free_line(self, pose: Pose2D, sign: int) -> tuple[Array, Array]:
        """Signed lengths (N,) of a line out of a pose as far as it is free, and clearances (N,)."""
        lengths = sign * np.arange(0.0, _LONGEST_ESCAPE, SPACING)
        poses = np.array([pose.moved(length) for length in lengths.tolist()])
        around = self._room.clearance(poses[:, :2])
        poses[:, 2] += self._flip
        free = self._room.stands_free(poses)
        touches = np.flatnonzero(free < min(CLEARANCE, free[0]) - 0.005)
        return lengths, around[: int(touches[0]) if len(touches) else None]

    def _straights(self, pose: Pose2D, signs: tuple[int, int]) -> list[float]:
        """Signed lengths of straight lines to places where the base can turn, best first."""
        room = self._room
        (here,) = room.clearance(np.array([pose[:2]]))
        if here >= self._turns_from:
            return [0.0]
        found = []
        for sign in signs:
            lengths, around = self._free_line(pose, sign)
            turns = np.flatnonzero(around >= room.turning)
            if len(turns):
                first = int(turns[0])
                run_up = [int(t) for t in turns if t <= first + round(_RUN_UP / SPACING)]
                found.append(float(lengths[run_up[-1] if signs[0] < 0 and sign < 0 else first]))
        return found

    def _along(
        self, a: Pose2D, out: float, line: Array, into: float, b: Pose2D, *, backwards: bool = False
    ) -> list[Leg]:
        """Legs out of `a`, along a line (N, 2), and into `b`."""
        before, after = np.array([a[:2], line[0]]), np.array([line[-1], b[:2]])
        if out != 0.0 and (out < 0.0) == backwards:
            line = np.concatenate([before[:1], line])
        if into != 0.0 and (into > 0.0) == backwards:
            line = np.concatenate([line, after[1:]])
        legs = self._driven(line, backwards=backwards)
        if out != 0.0 and (out < 0.0) != backwards:
            legs = self._driven(before, backwards=out < 0.0) + legs
        if into != 0.0 and (into > 0.0) != backwards:
            legs += self._driven(after, backwards=into > 0.0)
        if not legs:
            turned, narrow = np.full(2, b.heading + self._flip), np.zeros(2, dtype=np.bool_)
            legs = [Leg(path_at(*b), backwards, turned, narrow)]
        return self._turned(legs, a, b) if self._holonomic else legs

    def _driven(self, line: Array, *, backwards: bool) -> list[Leg]:
        flip = pi if backwards else 0.0

        room, turned = self._room, np.array([0.0, 0.0, flip + self._flip])

        def stands_free(poses: Array) -> Array:
            if self._holonomic:  # with any heading
                around = room.clearance(poses[:, :2]) - room.circumscribed
                return around + CLEARANCE
            return room.stands_free(poses + turned)

        def is_free(arc: Array) -> bool:
            clearances = stands_free(arc)
            least = min(CLEARANCE, clearances[0], clearances[-1]) - _NO_NEARER
            return bool((clearances >= least).all())

        speed = self._back if backwards else self._ahead
        legs = []
        for path in paths_along(line, stands_free, is_free, speed, self._turn_rate):
            headings = path.points[:, 2] + flip + self._flip
            narrow = self._room.clearance(path.points[:, :2]) < self._room.turning
            legs.append(Leg(path, backwards, headings, narrow))
        return legs

    def _turned(self, legs: list[Leg], a: Pose2D, b: Pose2D) -> list[Leg]:
        """The legs with the headings of a holonomic base: constant in every narrow place."""
        points = np.concatenate([leg.path.points for leg in legs])
        narrow = np.concatenate([leg.narrow for leg in legs])
        headings = np.full(len(points), b.heading)
        ends = np.flatnonzero(np.diff(narrow, append=False, prepend=False))
        for first, last in reversed(list(zip(ends[::2], ends[1::2], strict=True))):
            way = points[first:last, 2]
            middle = float(way[len(way) // 2])
            wishes = [middle, middle + pi, headings[last % len(points)]]
            wishes = [a.heading, *wishes] if first == 0 else [b.heading, *wishes]
            for wish in wishes:
                poses = np.column_stack([points[first:last, :2], np.full(len(way), wish)])
                if (self._room.stands_free(poses) >= CLEARANCE / 2.0).all():
                    headings[:last] = wish
                    break
            else:
                headings[first:last] = way
                headings[:first] = way[0]
        starts = np.cumsum([0, *(len(leg.headings) for leg in legs)])
        return [
            leg._replace(headings=headings[start : start + len(leg.headings)])
            for leg, start in zip(legs, starts[:-1].tolist(), strict=True)
        ]
