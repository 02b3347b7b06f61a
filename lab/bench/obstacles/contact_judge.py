"""Judge of contacts with obstacles: every part of the robot in every sample of a motion."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from pinocchio import SE3

from config.arrays import Array, Mask
from lab.bench.contacts import SURFACE
from lab.bench.obstacles.convex_distances import Placed, distances
from lab.bench.obstacles.judged_shapes import RobotShapes
from lab.bench.obstacles.walkers import STILL, Walker, could_have_left, remaining_speed
from robots import Geom, Plane, RobotDescription

NEAR = 0.25  # distances larger than this are not measured [m]

_FLOOR = Geom(Plane(), SE3.Identity(), "floor")
_STANDS = ("base", "link0", "link1")  # parts that cannot touch the floor, or stand on it


@dataclass(frozen=True, kw_only=True)
class Touch:
    """Contact of one part of the robot with one obstacle."""

    part: str
    obstacle: str
    samples: int
    depth: float  # the deepest [m]
    time: float  # of the first contact [s]
    avoidable: bool = True  # whether the robot could have avoided it


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """All contacts of a motion."""

    touches: tuple[Touch, ...]
    samples: int  # number of samples with a contact
    avoidable_samples: int  # number of samples with an avoidable contact
    clearance: float  # the least distance to any obstacle but the floor [m]; at most `NEAR`
    nearest: str  # which part comes nearest to which obstacle


class Judge:
    """Judges the motions of one robot."""

    def __init__(self, robot: RobotDescription) -> None:
        self._robot = robot
        self._shapes = RobotShapes(robot)

    def clearances(self, base: Array, q: Array, fixtures: Sequence[Geom]) -> Array:
        """(k,) least distance to the fixtures and of the hand to the floor, at most `NEAR` [m].

        `base` is (k, 3) x, y [m] and heading [rad], `q` (k, j) joint positions [rad]; fixtures are
        boxes and upright cylinders in the world.
        """
        least = np.full(len(base), NEAR)
        parts = self._shapes.placed(base, q)
        for obstacle in (_FLOOR, *fixtures):
            fixed = Placed.fixed(obstacle, len(base))
            for _, distance in _by_part(parts, fixed, obstacle is _FLOOR):
                least = np.minimum(least, distance)
        return np.asarray(least)

    def walker_clearances(self, base: Array, q: Array, walker: Walker, times: Array) -> Array:
        """(k,) least distance to a walker at times (k,), at most `NEAR` [m]."""
        parts, around = self._shapes.placed(base, q), _walking(walker, times)
        return np.asarray(
            np.min([np.full(len(base), NEAR), *(d for _, d in _by_part(parts, around))], axis=0)
        )

    def __call__(
        self,
        base: Array,
        q: Array,
        period: float,
        fixtures: Sequence[Geom],
        walkers: Sequence[Walker] = (),
    ) -> Verdict:
        """All contacts of a motion.

        Arguments as for `clearances`; `period` is that of the samples [s].
        """
        touches, clearance, nearest = [], NEAR, ""
        count = len(base)
        touched, avoidable = np.zeros(count, bool), np.zeros(count, bool)
        parts = self._shapes.placed(base, q)

        def judge(obstacle: str, around: Placed, excused: Mask, standing: bool = False) -> None:
            nonlocal clearance, nearest
            for part, distance in _by_part(parts, around, standing):
                inside = distance < -SURFACE
                if not standing and distance.min() < clearance:
                    clearance, nearest = float(distance.min()), f"{part} and {obstacle}"
                if inside.any():
                    touched[inside] = True
                    avoidable[inside & ~excused] = True
                    touches.append(
                        Touch(
                            part=part,
                            obstacle=obstacle,
                            samples=int(inside.sum()),
                            depth=float(-distance.min()),
                            time=float(np.argmax(inside)) * period,
                            avoidable=bool((inside & ~excused).any()),
                        )
                    )

        never = np.zeros(count, bool)
        for fixture in (_FLOOR, *fixtures):
            judge(fixture.name, Placed.fixed(fixture, count), never, fixture is _FLOOR)
        times = np.asarray(np.arange(count) * period, float)
        for walker in walkers:
            around = _walking(walker, times)
            judge(walker.name, around, self._excused(parts, around, base, q, period, walker))
        return Verdict(
            touches=tuple(touches),
            samples=int(touched.sum()),
            avoidable_samples=int(avoidable.sum()),
            clearance=clearance,
            nearest=nearest,
        )

    def _excused(
        self,
        parts: list[tuple[str, Placed]],
        around: Placed,
        base: Array,
        q: Array,
        period: float,
        walker: Walker,
    ) -> Mask:
        """(k,) contacts with a walker that the robot could not have avoided."""
        least = np.min([distance for _, distance in _by_part(parts, around)], axis=0)
        inside = least < -SURFACE
        excused = np.zeros(len(base), bool)
        begins = np.flatnonzero(inside & ~np.concatenate([[False], inside[:-1]]))
        for first in begins.tolist():
            after = np.flatnonzero(~inside[first:])
            last = first + int(after[0]) if len(after) else len(base)
            before = max(first - 1, 0)
            earlier = self._shapes.placed(base[[before]], q[[before]])
            there = around.at(np.array([first]))
            closing = min(float(d[0]) for _, d in _by_part(earlier, there)) - least[first]
            remaining = remaining_speed(self._robot, base, period, walker, first)
            runs_into_it = closing > max(STILL, remaining) * period
            leaves = could_have_left(self._robot, base, period, walker, first)
            excused[first:last] = not runs_into_it and not leaves
        return excused


def _walking(walker: Walker, times: Array) -> Placed:
    positions = walker.positions(times)
    R = np.broadcast_to(np.eye(3), (len(positions), 3, 3))
    return Placed(walker.shape, R, positions)


def _by_part(
    parts: list[tuple[str, Placed]], around: Placed, standing: bool = False
) -> Iterator[tuple[str, Array]]:
    """The distance of every part, the least of those that share a name."""
    found: dict[str, Array] = {}
    for name, part in parts:
        if not (standing and name in _STANDS):
            distance = distances(part, around, NEAR)
            found[name] = np.minimum(found[name], distance) if name in found else distance
    yield from found.items()
