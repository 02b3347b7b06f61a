"""Objects side by side on a level area: where the scene file says, or drawn from a seed."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from typing import NamedTuple, TypeAlias

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.contact import separation
from hw.sim.furniture import Objects
from hw.sim.items import make_item
from hw.sim.meshes import MeshError
from hw.sim.objects import OBJECT_CLASSES, fitting, make_object
from hw.sim.scene import SceneError
from hw.sim.sim_object import SimObject
from robots import Array, Geom, bounding_radius

GAP = 0.006  # Objects lie at least this far apart [m] ...

WALL_GAP = 0.022
"""... and this far from walls and edges; a finger just fits between an object and a wall [m]."""

_SPREADS = np.repeat([0.035, 0.025, 0.015, 0.008, 0.0, 0.0], 6)
"""Added to both gaps at each try of an orientation: generous first, none in the end [m]."""

_POSITIONS = 10  # How many positions are tried for each orientation of an object

_LAYOUTS = 30  # How many layouts, each with new objects, are tried before giving up

Keys: TypeAlias = tuple[str | int, ...]


class LayoutError(SceneError):
    """Things cannot be made, or do not fit.

    Args:
        text: what is wrong, and a hint.
        keys: on the way to them in the scene file.
    """

    def __init__(self, text: str, keys: Keys) -> None:
        super().__init__(text)
        self.keys = keys
        self.all: tuple[LayoutError, ...] = (self,)
        """This one and the others that were found with it."""


class Area(NamedTuple):
    """A level rectangle that objects lie on."""

    name: str  # For messages: "into the container", "on a table"
    centre: tuple[float, float]
    size: tuple[float, float]  # Along x and y [m]
    height: float
    keys: Keys  # On the way to its objects in the scene file


class _Wish(NamedTuple):
    """An object that has no place yet."""

    obj: SimObject
    yaw: float | None  # Drawn if it is None [rad]


def lay_out(wanted: Objects, area: Area, before: int, rng: np.random.Generator) -> list[SimObject]:
    """Objects side by side on an area; their numbers go on from `before`.

    Raises:
        LayoutError: they cannot be made, or do not fit.
    """
    widths = (wanted.width_mm[0] / 1000.0, wanted.width_mm[1] / 1000.0)
    masses = (wanted.mass_g[0] / 1000.0, wanted.mass_g[1] / 1000.0)
    names = fitting(OBJECT_CLASSES, wanted.kinds, widths)
    if wanted.drawn and not names:
        low, high = wanted.width_mm
        raise LayoutError(
            f"objects: no {' or '.join(wanted.kinds)} is {low:g} to {high:g} mm wide; "
            "widen width_mm or name other kinds",
            area.keys,
        )
    for _ in range(_LAYOUTS):
        drawn = [
            make_object(f"{name} {before + i + 1}", OBJECT_CLASSES[name], widths, masses, rng)
            for i, name in enumerate(rng.choice(names, wanted.drawn) if wanted.drawn else [])
        ]
        items = _items(wanted, area, before + len(drawn), rng)
        wishes = [_Wish(obj, None) for obj in drawn]
        laid = []
        for item, obj in zip(wanted.items, items, strict=True):
            if item.at is None:
                yaw = None if item.yaw_deg is None else float(np.deg2rad(item.yaw_deg))
                wishes.append(_Wish(obj, yaw))
            else:
                laid.append(obj)
        if _find_places(wishes, laid, area, rng):
            return [*drawn, *items]
    raise LayoutError(
        f"objects: {wanted.drawn + len(wanted.items)} do not fit {area.name}; lower count or "
        "width_mm, or enlarge what they lie on",
        area.keys,
    )


def _items(wanted: Objects, area: Area, before: int, rng: np.random.Generator) -> list[SimObject]:
    """The items, those with a place at their place."""
    items: list[SimObject] = []
    placed: list[SimObject] = []
    problems: list[LayoutError] = []
    for number, item in enumerate(wanted.items):
        keys = (*area.keys, "items", number)
        try:
            obj = make_item(item, before + number + 1, wanted, rng)
        except MeshError as error:
            problems.append(LayoutError(f"items.{number}.mesh: {error}", (*keys, "mesh")))
            continue
        items.append(obj)
        if item.at is None:
            continue
        low, high = _turned(obj, float(np.deg2rad(item.yaw_deg or 0.0)))
        _put(obj, np.array(item.at) - (low + high) / 2.0, area)
        beyond = np.abs(np.array(item.at) - area.centre) + (high - low) / 2.0
        if (beyond > np.array(area.size) / 2.0).any():
            text = (
                f"items.{number}: at {list(item.at)} it does not fit {area.name}, whose middle is "
                f"at {list(area.centre)}; move it, or enlarge what it lies on"
            )
            problems.append(LayoutError(text, (*keys, "at")))
        for other in placed:
            if not _apart(obj, other, 0.0):
                text = f"items.{number}: it overlaps {other.name}; move one of them"
                problems.append(LayoutError(text, (*keys, "at")))
        placed.append(obj)
    if problems:
        problems[0].all = tuple(problems)
        raise problems[0]
    return items


def _find_places(
    wishes: Sequence[_Wish], placed: Sequence[SimObject], area: Area, rng: np.random.Generator
) -> bool:
    """Give every object a pose beside those placed, the largest first; False if they do not fit."""
    laid = list(placed)
    for obj, yaw in sorted(wishes, key=lambda wish: -wish.obj.radius):
        if not any(_try_turned(obj, yaw, laid, area, spread, rng) for spread in _SPREADS):
            return False
        laid.append(obj)
    return True


def _try_turned(
    obj: SimObject,
    yaw: float | None,
    laid: Sequence[SimObject],
    area: Area,
    spread: float,
    rng: np.random.Generator,
) -> bool:
    """Turn an object, by chance if no yaw is given, and try positions clear of rim and others."""
    half = np.array(area.size) / 2.0 - WALL_GAP - spread
    low, high = _turned(obj, rng.uniform(-np.pi, np.pi) if yaw is None else yaw)
    low, high = -half - low, half - high
    if (low > high).any():
        return False
    for position in area.centre + rng.uniform(low, high, (_POSITIONS, 2)):
        _put(obj, position, area)
        if all(_apart(obj, other, GAP + spread) for other in laid):
            return True
    return False


def _turned(obj: SimObject, yaw: float) -> tuple[Array, Array]:
    """Turn an object at the origin; where it begins and ends (2,) along x and y [m]."""
    obj.pose = SE3(exp3(np.array([0.0, 0.0, yaw])), np.zeros(3))
    x, y, _ = np.eye(3)
    low, high = [-obj.reach(-x), -obj.reach(-y)], [obj.reach(x), obj.reach(y)]
    return np.array(low), np.array(high)


def _put(obj: SimObject, position: Array, area: Area) -> None:
    """Let an object rest on an area at a position (2,) of the world."""
    obj.pose = SE3(obj.pose.rotation, np.zeros(3))
    height = area.height + obj.reach(np.array([0.0, 0.0, -1.0]))
    obj.pose = SE3(obj.pose.rotation, np.array([*position, height]))


def _apart(a: SimObject, b: SimObject, gap: float) -> bool:
    (x, y, _), (u, v, _) = a.pose.translation, b.pose.translation
    if hypot(x - u, y - v) > a.radius + b.radius + gap:
        return True
    others = b.placed()
    return all(_clear(p, q, gap) or separation(p, q)[0] >= gap for p in a.placed() for q in others)


def _clear(p: Geom, q: Geom, gap: float) -> bool:
    """Whether even the balls around two parts are apart."""
    away = p.pose.translation - q.pose.translation
    within = bounding_radius(p.shape) + bounding_radius(q.shape) + gap
    return float(away @ away) > within * within
