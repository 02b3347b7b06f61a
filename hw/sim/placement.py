"""Placement of objects side by side on a level area: given in the scene file, or random."""

from collections.abc import Sequence
from dataclasses import replace
from math import hypot
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.contact import Vicinity, separation
from hw.sim.meshes import MeshError, convex_parts, fewer
from hw.sim.objects import (
    OBJECT_CLASSES,
    PAINT,
    body_of,
    fitting,
    make_object,
    mass_properties,
)
from hw.sim.scene_schema import Item, Objects, SceneError
from hw.sim.sim_object import Mesh, SimObject
from robots import Array, Geom, bounding_radius

GAP = 0.006  # between two objects, at least [m]
WALL_GAP = 0.022  # to walls and edges, at least; a finger just fits in between [m]
_INSIDE = 1e-4  # overlap with furniture that counts [m]
_EXTRA_GAPS = np.repeat([0.035, 0.025, 0.015, 0.008, 0.0, 0.0], 6)  # at each try [m]
_POSITIONS = 10  # tried for each orientation of an object
_LAYOUTS = 30  # tried, each with new objects

Keys: TypeAlias = tuple[str | int, ...]  # path of an entry in the scene file


class LayoutError(SceneError):
    """Objects cannot be made, or do not fit."""

    def __init__(self, text: str, keys: Keys) -> None:
        super().__init__(text)
        self.keys = keys
        self.all: tuple[LayoutError, ...] = (self,)  # with the others found at once


class Area(NamedTuple):
    """A level rectangle that objects lie on."""

    name: str  # for messages: "into the container", "on a table"
    centre: tuple[float, float]
    size: tuple[float, float]  # along x and y [m]
    height: float
    keys: Keys  # of its objects
    around: Vicinity  # furniture, some of which may stand on it or hang above


class _Unplaced(NamedTuple):
    obj: SimObject
    yaw: float | None  # [rad]; None: random


def place_objects(
    wanted: Objects, area: Area, before: int, rng: np.random.Generator
) -> list[SimObject]:
    """Objects side by side on an area, numbered on from `before`; LayoutError: they do not fit."""
    widths = (wanted.width_mm[0] / 1000.0, wanted.width_mm[1] / 1000.0)
    masses = (wanted.mass_g[0] / 1000.0, wanted.mass_g[1] / 1000.0)
    names = fitting(OBJECT_CLASSES, wanted.kinds, widths)
    count = wanted.random_count
    if count and not names:
        low, high = wanted.width_mm
        raise LayoutError(
            f"objects: no {' or '.join(wanted.kinds)} is {low:g} to {high:g} mm wide; "
            "widen width_mm or name other kinds",
            area.keys,
        )
    for _ in range(_LAYOUTS):
        drawn = [
            make_object(f"{name} {before + i + 1}", OBJECT_CLASSES[name], widths, masses, rng)
            for i, name in enumerate(rng.choice(names, count) if count else [])
        ]
        items = _items(wanted, area, before + len(drawn), rng)
        unplaced = [_Unplaced(obj, None) for obj in drawn]
        placed = []
        for item, obj in zip(wanted.items, items, strict=True):
            if item.at is None:
                yaw = None if item.yaw_deg is None else float(np.deg2rad(item.yaw_deg))
                unplaced.append(_Unplaced(obj, yaw))
            else:
                placed.append(obj)
        if _find_places(unplaced, placed, area, rng):
            return [*drawn, *items]
    raise LayoutError(
        f"objects: {count + len(wanted.items)} do not fit {area.name}; lower count or "
        "width_mm, or enlarge what they lie on",
        area.keys,
    )


def _items(wanted: Objects, area: Area, before: int, rng: np.random.Generator) -> list[SimObject]:
    items: list[SimObject] = []
    placed: list[SimObject] = []
    problems: list[LayoutError] = []
    for number, item in enumerate(wanted.items):
        keys = (*area.keys, "items", number)
        try:
            obj = _make_item(item, before + number + 1, wanted, rng)
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
        if (furniture := _inside(obj, area)) is not None:
            text = f"items.{number}: it is inside {furniture}; move one of them"
            problems.append(LayoutError(text, (*keys, "at")))
        placed.append(obj)
    if problems:
        problems[0].all = tuple(problems)
        raise problems[0]
    return items


def _make_item(item: Item, number: int, others: Objects, rng: np.random.Generator) -> SimObject:
    """One item, resting on z = 0 with its centre of mass above 0; MeshError: of its mesh."""
    masses = others.mass_g[0] / 1000.0, others.mass_g[1] / 1000.0
    if item.kind is not None:
        of_kind = OBJECT_CLASSES[item.kind]
        widths = (others.width_mm[0] / 1000.0, others.width_mm[1] / 1000.0)
        if not fitting(OBJECT_CLASSES, [item.kind], widths):
            widths = (of_kind.narrowest, of_kind.widest)
        made = make_object(f"{item.kind} {number}", of_kind, widths, masses, rng)
    else:
        made = _make_mesh_object(item, number, masses, rng)
    if item.colour is not None:
        paint = PAINT[item.colour]
        made = replace(made, parts=tuple(Geom(p.shape, p.pose, p.name, paint) for p in made.parts))
    return replace(
        made,
        mass=made.mass if item.mass_g is None else item.mass_g / 1000.0,
        friction=made.friction if item.friction is None else item.friction,
    )


def _make_mesh_object(
    item: Item, number: int, masses: tuple[float, float], rng: np.random.Generator
) -> SimObject:
    assert item.mesh is not None
    mesh = item.read()
    parts = convex_parts(mesh, Path(item.mesh).name)
    made = body_of(f"{Path(item.mesh).stem[:40]} {number}", parts, masses, rng)
    drawn, (_, centre) = fewer(mesh), mass_properties(parts)
    made.mesh = Mesh(drawn.vertices - centre, drawn.triangles, drawn.closed)
    made.pose = SE3.Identity()
    made.pose = SE3(np.eye(3), np.array([0.0, 0.0, made.reach(np.array([0.0, 0.0, -1.0]))]))
    return made


def _find_places(
    unplaced: Sequence[_Unplaced], placed: Sequence[SimObject], area: Area, rng: np.random.Generator
) -> bool:
    """Give every object a pose beside those placed, the largest first; False if they do not fit."""
    placed = list(placed)
    for obj, yaw in sorted(unplaced, key=lambda one: -one.obj.radius):
        if not any(_try_turned(obj, yaw, placed, area, extra, rng) for extra in _EXTRA_GAPS):
            return False
        placed.append(obj)
    return True


def _try_turned(
    obj: SimObject,
    yaw: float | None,
    placed: Sequence[SimObject],
    area: Area,
    extra: float,
    rng: np.random.Generator,
) -> bool:
    """Turn an object, randomly if no yaw is given, and try positions clear of all else."""
    half = np.array(area.size) / 2.0 - WALL_GAP - extra
    low, high = _turned(obj, rng.uniform(-np.pi, np.pi) if yaw is None else yaw)
    low, high = -half - low, half - high
    if (low > high).any():
        return False
    for position in area.centre + rng.uniform(low, high, (_POSITIONS, 2)):
        _put(obj, position, area)
        is_apart = all(_apart(obj, other, GAP + extra) for other in placed)
        if is_apart and _inside(obj, area) is None:
            return True
    return False


def _turned(obj: SimObject, yaw: float) -> tuple[Array, Array]:
    """Turn an object at the origin; its extent (2,) to (2,) along x and y [m]."""
    obj.pose = SE3(exp3(np.array([0.0, 0.0, yaw])), np.zeros(3))
    x, y, _ = np.eye(3)
    low, high = [-obj.reach(-x), -obj.reach(-y)], [obj.reach(x), obj.reach(y)]
    return np.array(low), np.array(high)


def _put(obj: SimObject, position: Array, area: Area) -> None:
    obj.pose = SE3(obj.pose.rotation, np.zeros(3))
    height = area.height + obj.reach(np.array([0.0, 0.0, -1.0]))
    obj.pose = SE3(obj.pose.rotation, np.array([*position, height]))


def _inside(obj: SimObject, area: Area) -> str | None:
    """The furniture that an object overlaps, as the board above it."""
    near = area.around.near(obj.pose.translation, obj.radius)
    pairs = ((part, one) for one in near for part in obj.placed())
    return next((one.name for part, one in pairs if separation(part, one)[0] < -_INSIDE), None)


def _apart(a: SimObject, b: SimObject, gap: float) -> bool:
    (x, y, _), (u, v, _) = a.pose.translation, b.pose.translation
    if hypot(x - u, y - v) > a.radius + b.radius + gap:
        return True
    others = b.placed()
    return all(_clear(p, q, gap) or separation(p, q)[0] >= gap for p in a.placed() for q in others)


def _clear(p: Geom, q: Geom, gap: float) -> bool:
    away = p.pose.translation - q.pose.translation
    within = bounding_radius(p.shape) + bounding_radius(q.shape) + gap
    return float(away @ away) > within * within
