"""The judge of contacts with what is around: every part of the robot in every sample."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from controller import Array
from lab.bench.obstacle_body import Body, moved
from lab.bench.obstacle_shapes import Placed, distances
from lab.bench.obstacle_walkers import STILL, Walker, could_have_left, still_braking
from robots import Geom, Plane, RobotDescription

Flags: TypeAlias = npt.NDArray[np.bool_]

SURFACE = 1e-6
"""Shapes that overlap by less than this do not touch [m]."""
NEAR = 0.25
"""Distances larger than this are not measured [m]."""

_FLOOR = Geom(Plane(), SE3.Identity(), "floor")
_STANDS = ("base", "link0", "link1")
"""What cannot touch the floor, or stands on it."""


@dataclass(frozen=True, kw_only=True)
class Touch:
    """One part of the robot touches one thing."""

    part: str
    thing: str
    samples: int
    depth: float
    """The deepest [m]."""
    time: float
    """When it begins [s]."""
    avoidable: bool = True
    """Whether the robot could have kept out of it."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What a motion touched, and what it did not touch."""

    touches: tuple[Touch, ...]
    samples: int
    """In which anything is touched."""
    avoidable_samples: int
    """In which anything is touched that need not have been."""
    clearance: float
    """The least distance to anything but the floor [m]; not larger than `NEAR`."""
    nearest: str
    """Which part comes nearest to what."""


class Judge:
    """Judges the motions of one robot.

    Args:
        robot: which.
    """

    def __init__(self, robot: RobotDescription) -> None:
        self._robot = robot
        self._body = Body(robot)

    def clearances(self, base: Array, q: Array, fixtures: Sequence[Geom]) -> Array:
        """(k,) least distance to the fixtures and of the hand to the floor, at most `NEAR` [m].

        Args:
            base: (k, 3) x, y [m] and heading [rad].
            q: (k, 7) joint positions [rad].
            fixtures: boxes and upright cylinders in the world.
        """
        least = np.full(len(base), NEAR)
        parts = self._body.placed(base, q)
        for thing in (_FLOOR, *fixtures):
            for _, distance in _of(parts, Placed.fixed(thing, len(base)), thing is _FLOOR):
                least = np.minimum(least, distance)
        return np.asarray(least)

    def walker_clearances(self, base: Array, q: Array, walker: Walker, times: Array) -> Array:
        """(k,) least distance to a walker at times (k,), at most `NEAR` [m]."""
        parts, around = self._body.placed(base, q), _walking(walker, times)
        return np.asarray(
            np.min([np.full(len(base), NEAR), *(d for _, d in _of(parts, around))], axis=0)
        )

    def __call__(
        self,
        base: Array,
        q: Array,
        period: float,
        fixtures: Sequence[Geom],
        walkers: Sequence[Walker] = (),
    ) -> Verdict:
        """What a motion touches.

        Args:
            base: (k, 3) x, y [m] and heading [rad].
            q: (k, 7) joint positions [rad].
            period: of the samples [s].
            fixtures: boxes and upright cylinders in the world.
            walkers: who moves around meanwhile.
        """
        touches, clearance, nearest = [], NEAR, ""
        count = len(base)
        touched, to_blame = np.zeros(count, bool), np.zeros(count, bool)
        parts = self._body.placed(base, q)

        def judge(thing: str, around: Placed, excused: Flags, standing: bool = False) -> None:
            nonlocal clearance, nearest
            for part, distance in _of(parts, around, standing):
                inside = distance < -SURFACE
                if not standing and distance.min() < clearance:
                    clearance, nearest = float(distance.min()), f"{part} and {thing}"
                if inside.any():
                    touched[inside] = True
                    to_blame[inside & ~excused] = True
                    touches.append(
                        Touch(
                            part=part,
                            thing=thing,
                            samples=int(inside.sum()),
                            depth=float(-distance.min()),
                            time=float(np.argmax(inside)) * period,
                            avoidable=bool((inside & ~excused).any()),
                        )
                    )

        never = np.zeros(count, bool)
        for fixture in (_FLOOR, *fixtures):
            judge(fixture.name, Placed.fixed(fixture, count), never, fixture is _FLOOR)
        for walker in walkers:
            around = _walking(walker, _times(count, period))
            excused = self._excused(parts, around, base, q, period, walker)
            judge(walker.name, around, excused)
        return Verdict(
            touches=tuple(touches),
            samples=int(touched.sum()),
            avoidable_samples=int(to_blame.sum()),
            clearance=clearance,
            nearest=nearest,
        )

    def nearest(
        self,
        base: Array,
        q: Array,
        period: float,
        fixtures: Sequence[Geom],
        walkers: Sequence[Walker] = (),
    ) -> list[tuple[float, str]]:
        """In every sample the least distance [m], at most `NEAR`, and of which part to what."""
        count = len(base)
        parts, times = self._body.placed(base, q), _times(count, period)
        around = [(fixture.name, Placed.fixed(fixture, count)) for fixture in fixtures]
        around += [(walker.name, _walking(walker, times)) for walker in walkers]
        least, what = np.full(count, NEAR), [""] * count
        for name, thing in around:
            for part, distance in _of(parts, thing):
                for sample in np.flatnonzero(distance < least):
                    least[sample], what[sample] = distance[sample], f"{part} and {name}"
        return list(zip(least.tolist(), what, strict=True))

    def _excused(
        self,
        parts: list[tuple[str, Placed]],
        around: Placed,
        base: Array,
        q: Array,
        period: float,
        walker: Walker,
    ) -> Flags:
        """(k,) contacts with a walker that the robot could not have avoided."""
        least = np.min([distance for _, distance in _of(parts, around)], axis=0)
        inside = least < -SURFACE
        excused = np.zeros(len(base), bool)
        begins = np.flatnonzero(inside & ~np.concatenate([[False], inside[:-1]]))
        for first in begins.tolist():
            after = np.flatnonzero(~inside[first:])
            last = first + int(after[0]) if len(after) else len(base)
            before = max(first - 1, 0)
            earlier = self._body.placed(base[[before]], q[[before]])
            there = around.at(np.array([first]))
            closing = min(float(d[0]) for _, d in _of(earlier, there)) - least[first]
            left = still_braking(self._robot, base, period, walker, first)
            runs_into_it = closing > max(STILL, left) * period
            leaves = could_have_left(self._robot, base, period, walker, first)
            excused[first:last] = not runs_into_it and not leaves
        return excused


def _times(count: int, period: float) -> Array:
    return np.asarray(np.arange(count) * period, float)


def _walking(walker: Walker, times: Array) -> Placed:
    return moved(Geom(walker.shape, SE3.Identity()), walker.positions(times))


def _of(
    parts: list[tuple[str, Placed]], around: Placed, standing: bool = False
) -> Iterator[tuple[str, Array]]:
    """The distances of every part with a name of its own, the least of those that share one."""
    found: dict[str, Array] = {}
    for name, part in parts:
        if not (standing and name in _STANDS):
            distance = distances(part, around, NEAR)
            found[name] = np.minimum(found[name], distance) if name in found else distance
    yield from found.items()
