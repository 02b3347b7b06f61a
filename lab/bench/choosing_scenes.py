"""Scenes of `bench choosing`: a few objects in a tray, and a request for one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import cv2
import numpy as np
import numpy.typing as npt
from pinocchio import SE3

from behaviours import Region
from hw import DepthFrame
from hw.sim import (
    HOUSEHOLD,
    Container,
    D435Noise,
    DepthRenderer,
    Objects,
    Scene,
    SimObject,
    Table,
    World,
    painted,
)
from hw.sim import build_world as _built
from perception import colour_name
from robots import Array, Intrinsics, load_robot

TRAY = (0.80, 0.0)
"""Middle of the tray, before the robot [m]."""
INNER = (0.44, 0.36)
FLOOR = 0.456
TRAY_REGION = Region(
    name="tray",
    wTr=SE3(np.eye(3), np.array([*TRAY, FLOOR + 0.1])),
    size=np.array([*INNER, 0.2]),
)
TABLE = Table(centre=(0.0, 2.5), size=(1.2, 0.6))
ASIDE = Region(
    name="table",
    wTr=SE3(np.eye(3), np.array([*TABLE.centre, TABLE.height + 0.1])),
    size=np.array([1.0, 0.4, 0.2]),
)
"""Where neighbours are put aside."""
HEIGHT = 0.42
"""Of the camera over the floor of the tray, straight above its middle [m]."""
CLUTTER = ("apart", "pairs", "cluster")
"""Arrangements: 6 mm or more apart; two pairs that touch; all pushed to one in the middle."""
_AHEAD = 1.1
"""Least ratio of the areas of the requested object and the next one, if requested by size."""
_WIDER = 0.004
"""Least difference of their widths from the limit, if requested by width [m]."""
_EYE = Intrinsics(width=400, height=400, fx=4000.0, fy=4000.0, cx=199.5, cy=199.5)
_ABOVE = 6.0
_TRIES = 200

Owners: TypeAlias = npt.NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class TrueObject:
    """True properties of an object, seen from above."""

    name: str
    colour: str
    area: float
    """Of its outline [m^2]."""
    width: float
    """Shorter edge of the smallest rectangle around the outline [m]."""
    middle: tuple[float, float]
    """Of that rectangle, x and y in the world [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Request:
    """A request for one object."""

    words: Mapping[str, object] = field(default_factory=dict)
    """Parameters of `grasp`."""
    name: str
    """Of the object; empty for the nearest, which depends on the robot."""

    @property
    def kind(self) -> str:
        """The properties that are requested, for a table."""
        by_width = any(word.endswith("width_mm") for word in self.words)
        parts = [str(self.words.get("choose", "")), "colour" if "colour" in self.words else ""]
        return " + ".join(part for part in (*parts, "width" if by_width else "") if part)


def make_scene(seed: int) -> tuple[World, str, Request]:
    """A world, the arrangement of its objects, and a request; always the same for a seed."""
    rng = np.random.default_rng((seed, 17))
    clutter = CLUTTER[seed % len(CLUTTER)]
    for _ in range(_TRIES):
        world = make_world(clutter, rng)
        objects = [true_object(obj) for obj in world.objects]
        make = _REQUESTS[(seed // len(CLUTTER)) % len(_REQUESTS)]
        if request := make(objects, rng):
            return world, clutter, request
    raise RuntimeError(f"no scene for seed {seed}")


def make_world(
    clutter: str, rng: np.random.Generator, kinds: Sequence[str] = tuple(HOUSEHOLD)
) -> World:
    """Five to eight objects of some classes in the tray, in one of the arrangements `CLUTTER`."""
    count = int(rng.integers(5, 9))
    scene = Scene(
        container=Container(centre=TRAY, inner_size=INNER, floor_height=FLOOR),
        table=TABLE,
        objects=Objects(count=count, kinds=tuple(kinds), width_mm=(15.0, 60.0)),
    )
    world = _built(scene, rng)
    if clutter == "pairs":
        for obj in world.objects[:2]:
            others = [other for other in world.objects if other is not obj]
            _push(world, obj, min(others, key=lambda other: _gap(other, obj.pose.translation)))
    elif clutter == "cluster":
        middle = min(world.objects, key=lambda obj: _gap(obj, np.array([*TRAY, 0.0])))
        others = sorted(world.objects, key=lambda obj: _gap(obj, middle.pose.translation))
        for obj in others[1:]:
            _push(world, obj, middle)
    return world


def _push(world: World, obj: SimObject, other: SimObject) -> None:
    """Push an object along the floor towards another one, until it is blocked."""
    way = other.pose.translation - obj.pose.translation
    way[2] = 0.0
    length = float(np.linalg.norm(way))
    world.push(obj, way / length, length)


def _gap(obj: SimObject, point: Array) -> float:
    return float(np.linalg.norm((obj.pose.translation - point)[:2]))


def seen_from_above(
    world: World,
    rng: np.random.Generator,
    *,
    height: float = HEIGHT,
    off: tuple[float, float] = (0.0, 0.0),
) -> tuple[DepthFrame, Owners]:
    """A noisy frame of the tray, and the number of the object in each pixel; -1 is none.

    Args:
        world: one of `make_world`.
        rng: of the noise.
        height: of the camera over the floor of the tray [m].
        off: of the camera from the middle of the tray along x and y [m].
    """
    camera = load_robot("frankie").camera
    position = np.array([TRAY[0] + off[0], TRAY[1] + off[1], FLOOR + height])
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), position)
    shapes = world.shapes()
    depth, ids = DepthRenderer(camera.intrinsics).render_with_ids(shapes, wTc)
    names = {obj.name: number for number, obj in enumerate(world.objects)}
    owner = np.array([*(names.get(shape.name, -1) for shape in shapes), -1])[ids]
    colours = painted(shapes, ids)
    frame = DepthFrame(
        depth=D435Noise().apply(depth, camera, rng),
        intrinsics=camera.intrinsics,
        wTc=wTc,
        stamp=0.0,
        paint=lambda: colours,
    )
    return frame, owner


def true_object(obj: SimObject) -> TrueObject:
    """The properties of an object at its true pose.

    Measured on an image of it alone, from a distance at which all rays are nearly parallel.
    """
    x, y, z = obj.pose.translation
    wTc = SE3(np.diag([1.0, -1.0, -1.0]), np.array([x, y, z + _ABOVE]))
    _, ids = DepthRenderer(_EYE).render_with_ids(obj.visual(), wTc)
    pixel = _ABOVE / _EYE.fx
    covered = np.argwhere(ids >= 0)
    (row, column), edges, _ = cv2.minAreaRect(covered.astype(np.float32))
    return TrueObject(
        name=obj.name,
        colour=colour_name(*obj.parts[0].colour),
        area=len(covered) * pixel**2,
        width=(min(edges) + 1.0) * pixel,
        middle=(x + (column - _EYE.cx) * pixel, y - (row - _EYE.cy) * pixel),
    )


_MakeRequest: TypeAlias = Callable[[Sequence[TrueObject], np.random.Generator], Request | None]


def _by_size(choose: str, sign: float) -> _MakeRequest:
    def make(objects: Sequence[TrueObject], rng: np.random.Generator) -> Request | None:
        first, second = sorted(objects, key=lambda one: sign * one.area)[:2]
        larger, smaller = (first, second) if sign < 0.0 else (second, first)
        if larger.area < _AHEAD * smaller.area:
            return None
        return Request(words={"choose": choose}, name=first.name)

    return make


def _by_width(word: str, sign: float) -> _MakeRequest:
    def make(objects: Sequence[TrueObject], rng: np.random.Generator) -> Request | None:
        first, second = sorted(objects, key=lambda one: sign * one.width)[:2]
        wider, narrower = (first, second) if sign < 0.0 else (second, first)
        if wider.width < narrower.width + 2.0 * _WIDER:
            return None
        limit = round(500.0 * (first.width + second.width))
        return Request(words={word: float(limit)}, name=first.name)

    return make


_largest = _by_size("largest", -1.0)


def _nearest(objects: Sequence[TrueObject], rng: np.random.Generator) -> Request | None:
    return Request(words={"choose": "nearest"}, name="")


def _of_colour(objects: Sequence[TrueObject], rng: np.random.Generator) -> Request | None:
    colours = [one.colour for one in objects]
    single = [one for one in objects if colours.count(one.colour) == 1]
    if not single:
        return None
    one = single[rng.integers(len(single))]
    return Request(words={"colour": one.colour}, name=one.name)


def _largest_of_colour(objects: Sequence[TrueObject], rng: np.random.Generator) -> Request | None:
    colours = [one.colour for one in objects]
    several = sorted({colour for colour in colours if colours.count(colour) > 1})
    if not several:
        return None
    colour = several[rng.integers(len(several))]
    request = _largest([one for one in objects if one.colour == colour], rng)
    return request and Request(words={**request.words, "colour": colour}, name=request.name)


_REQUESTS: tuple[_MakeRequest, ...] = (
    _largest,
    _by_size("smallest", 1.0),
    _nearest,
    _of_colour,
    _largest_of_colour,
    _by_width("min_width_mm", -1.0),
    _by_width("max_width_mm", 1.0),
)
