"""Simulated laser: where level beams first meet the shapes of a world, in closed form.

A beam o + t d is inside of a convex shape for an interval of t, which is the intersection of its
intervals inside of half-spaces and infinite cylinders (Cyrus and Beck 1978).
"""

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import TypeAlias

import numpy as np
from pinocchio import SE3

from hw.robot import PassivePart
from hw.sim.body import SimBody
from hw.sim.sim_world import World
from hw.state import Array, LaserReading
from robots import Box, Capsule, Cylinder, Geom, Hull, LaserDescription, Shape, Sphere, reach

_Interval: TypeAlias = tuple[Array, Array]
_Placed: TypeAlias = tuple[SE3, float, float]
_PARALLEL = 1e-12
_UP = np.array([0.0, 0.0, 1.0])
_STREAM = 1  # tells the noise of the laser from that of other sensors with the same seed


class SimLaser(PassivePart):
    """The laser as a part of the robot: scans on demand, at most once a period."""

    def __init__(self, body: SimBody, laser: LaserDescription, seed: int) -> None:
        self._body, self._laser, self._seed = body, laser, seed
        height = float(laser.bTs.translation[2])
        self._still = Solids(one for one in body.world.fixtures if _crosses(one, height))
        self._number = -1
        self._reading: LaserReading | None = None

    def latest(self) -> LaserReading | None:
        """The newest scan."""
        self._body.advance()
        number = int(self._body.now * self._laser.rate + 1e-9)
        if number != self._number:
            self._number = number
            self._reading = self.scan(number)
        return self._reading

    def scan(self, number: int) -> LaserReading:
        """A scan of this moment, with noise seeded by its number."""
        rng = np.random.default_rng((self._seed, number, _STREAM))
        body, laser = self._body, self._laser
        origin = body.wTb.act(laser.bTs.translation)
        beams = laser.beams @ body.wTb.rotation.T
        moving = Solids(_moving(body.world, float(origin[2])))
        ranges = np.minimum(self._still.ranges(origin, beams), moving.ranges(origin, beams))
        noise = laser.noise * rng.standard_normal(len(ranges))
        measured = np.where(ranges <= laser.max_range, ranges + noise, np.inf)
        return LaserReading(stamp=body.now, ranges=measured, points=laser.points(measured))


def _moving(world: World, height: float) -> Iterator[Geom]:
    for obj in world.objects:
        if obj is not world.held and abs(obj.pose.translation[2] - height) <= obj.radius:
            yield from obj.placed()
    for walker in world.walkers:
        yield from walker.placed()


def _crosses(geom: Geom, height: float) -> bool:
    if not isinstance(geom.shape, Box | Hull | Cylinder | Capsule | Sphere):
        return False
    return -reach(geom, -_UP) <= height <= reach(geom, _UP)


class Solids:
    """Shapes in the world, as arrays for all beams at once; planes are left out."""

    def __init__(self, shapes: Iterable[Geom]) -> None:
        flat: list[Geom] = []
        cylinders: list[_Placed] = []
        capsules: list[_Placed] = []
        for one in shapes:
            match one.shape:
                case Box() | Hull():
                    flat.append(one)
                case Cylinder(radius, half_length):
                    cylinders.append((one.pose, radius, half_length))
                case Capsule(radius, half_length):
                    capsules.append((one.pose, radius, half_length))
                case Sphere(radius):
                    capsules.append((one.pose, radius, 0.0))
        self._kinds: list[_Polyhedra | _Round] = [_Polyhedra(flat)] if flat else []
        self._kinds += [_Round(cylinders, balls=False)] if cylinders else []
        self._kinds += [_Round(capsules, balls=True)] if capsules else []

    def ranges(self, origin: Array, beams: Array) -> Array:
        """(n,) ranges of beams (n, 3) from (3,) in the world [m]; infinite without a shape."""
        nearest = np.full(len(beams), np.inf)
        for kind in self._kinds:
            for enter, leave in kind.intervals(origin, beams):
                seen = np.where((enter <= leave) & (enter > 0.0), enter, np.inf)
                nearest = np.minimum(nearest, seen.min(axis=0))
        return nearest


class _Polyhedra:
    """Boxes and hulls as half-spaces n·x <= c."""

    def __init__(self, shapes: Sequence[Geom]) -> None:
        spaces = [_half_spaces(one.shape) for one in shapes]
        normals = [n @ one.pose.rotation.T for one, (n, _) in zip(shapes, spaces, strict=True)]
        self._normals = np.concatenate(normals)
        self._offsets = np.concatenate(
            [
                c + n @ one.pose.translation
                for one, (_, c), n in zip(shapes, spaces, normals, strict=True)
            ]
        )
        self._begins = np.cumsum([0, *map(len, normals[:-1])])

    def intervals(self, origin: Array, beams: Array) -> Iterator[_Interval]:
        """Of m shapes and n beams, each (m, n)."""
        along = self._normals @ beams.T
        along[np.abs(along) < _PARALLEL] = _PARALLEL
        at = (self._offsets - self._normals @ origin)[:, None] / along
        enter = np.maximum.reduceat(np.where(along < 0.0, at, -np.inf), self._begins)
        yield enter, np.minimum.reduceat(np.where(along > 0.0, at, np.inf), self._begins)


class _Round:
    """Cylinders: pose, radius, half a length along z. With balls at their ends, capsules."""

    def __init__(self, shapes: Sequence[_Placed], *, balls: bool) -> None:
        self._rotation = np.array([pose.rotation for pose, _, _ in shapes])
        self._position = np.array([pose.translation for pose, _, _ in shapes])
        self._radius = np.array([[radius] for _, radius, _ in shapes])
        self._half = np.array([[half] for _, _, half in shapes])
        self._balls = balls

    def intervals(self, origin: Array, beams: Array) -> Iterator[_Interval]:
        """Of m cylinders and n beams, each (m, n); then of the balls."""
        o = np.einsum("mi,mij->mj", origin - self._position, self._rotation)[:, None, :]
        d = beams @ self._rotation
        enter, leave = _in_ball(o[..., :2], d[..., :2], self._radius)
        slope = np.where(np.abs(d[..., 2]) < _PARALLEL, _PARALLEL, d[..., 2])
        ends = (-self._half - o[..., 2]) / slope, (self._half - o[..., 2]) / slope
        yield np.maximum(enter, np.minimum(*ends)), np.minimum(leave, np.maximum(*ends))
        if self._balls:
            for end in (-self._half, self._half):
                yield _in_ball(o - end[..., None] * _UP, d, self._radius)


def _in_ball(o: Array, d: Array, radius: Array) -> _Interval:
    """Intervals (m, n) of beams in balls or circles around 0: (m, 1, k) o, (m, n, k) d."""
    a = np.maximum(np.einsum("mnk,mnk->mn", d, d), _PARALLEL)
    b = (o * d).sum(axis=-1)
    root = b * b - a * ((o * o).sum(axis=-1) - radius**2)
    half = np.sqrt(np.maximum(root, 0.0))
    return np.where(root >= 0.0, (-b - half) / a, np.inf), (-b + half) / a


@cache
def _half_spaces(shape: Shape) -> tuple[Array, Array]:
    """Outward normals (P, 3), of any length, and offsets (P,) of a box or hull in its frame."""
    if isinstance(shape, Box):
        return np.concatenate([np.eye(3), -np.eye(3)]), np.array([*shape.half, *shape.half])
    assert isinstance(shape, Hull)
    a, b, c = shape.vertices[shape.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    return normals, np.einsum("ij,ij->i", normals, a)
