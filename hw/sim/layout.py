"""Build the world of a scene: fixtures at their poses, objects side by side on their surface."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.contact import separation
from hw.sim.furniture import Container, Fixture, Footprint, Objects, SideTable, Table
from hw.sim.objects import OBJECT_CLASSES, fitting, make_object
from hw.sim.scene import Scene, SceneError, place, read_scene
from hw.sim.sim_object import Motion, SimObject
from hw.sim.walker import Walker
from hw.sim.world import World
from robots import Box, Colour, Geom, Plane

GAP = 0.006
"""Objects lie at least this far apart [m] ..."""

WALL_GAP = 0.022
"""... and this far from walls and edges; a finger just fits between an object and a wall [m]."""

_SPREADS = np.repeat([0.035, 0.025, 0.015, 0.008, 0.0, 0.0], 6)
"""Added to both gaps at each try of an orientation: generous first, none in the end [m]."""

_POSITIONS = 10
"""How many positions are tried for each orientation of an object."""

_LAYOUTS = 30
"""How many layouts, each with new objects, are tried before giving up."""

Keys: TypeAlias = tuple[str | int, ...]

_FLOOR: Colour = (196, 190, 180)
_WOOD: Colour = (176, 136, 96)
_PLASTIC: Colour = (120, 150, 170)
_STONE: Colour = (150, 150, 150)


class LayoutError(SceneError):
    """Objects cannot be made, or do not fit.

    Args:
        text: what is wrong, and a hint.
        keys: on the way to the objects in the scene file.
    """

    def __init__(self, text: str, keys: Keys) -> None:
        super().__init__(text)
        self.keys = keys


def load_scene(scene: str | Path, seed: int, footprint: Footprint | None = None) -> World:
    """Build the world that a scene describes.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        seed: of the objects and their poses; the same seed gives the same world.
        footprint: of the robot that starts in it; None leaves the start unchecked.

    Raises:
        SceneError: there is no such scene, its file is not valid, or the objects do not fit.
    """
    described = read_scene(scene, footprint)
    try:
        return build_world(described, np.random.default_rng(seed))
    except LayoutError as error:
        raise SceneError(f"{place(scene, error.keys)}: {error}") from error


def build_world(scene: Scene, rng: np.random.Generator) -> World:
    """Build the world of a scene that was read.

    Raises:
        LayoutError: the objects cannot be made, or do not fit.
    """
    boxes = [_fixture(one) for one in scene.fixtures]
    unmapped = [box for box, one in zip(boxes, scene.fixtures, strict=True) if not one.on_map]
    fixtures = [*_furniture(scene), *boxes]
    objects = _objects(scene.objects, _floor(scene.container), 0, rng)
    for number, table in enumerate(scene.side_tables):
        lying = _objects(table.objects, _top(table, number), len(objects), rng)
        objects += [_moving(obj, table) for obj in lying]
    walkers = [Walker(w.name, w.radius, w.height, w.way, w.speed) for w in scene.walkers]
    return World(fixtures, objects, walkers, unmapped)


def load_fixtures(scene: str | Path) -> tuple[Geom, ...]:
    """What a scene says that stands around and never moves, as on a map.

    Args:
        scene: name of a shipped scene, or path of a scene file.

    Raises:
        SceneError: there is no such scene, or its file is not valid.
    """
    described = read_scene(scene)
    mapped = [_fixture(one) for one in described.fixtures if one.on_map]
    return (*_furniture(described), *mapped)


def _furniture(scene: Scene) -> list[Geom]:
    """The floor, the container and all tables."""
    return [
        Geom(Plane(), SE3.Identity(), "floor", _FLOOR),
        *_container(scene.container),
        *_table(scene.table, "table"),
        *(part for table in scene.side_tables for part in _table(table, table.name)),
    ]


class _Surface(NamedTuple):
    """A level rectangle that objects lie on."""

    name: str
    """For messages: "into the container", "on a table"."""
    centre: tuple[float, float]
    size: tuple[float, float]
    """Along x and y [m]."""
    height: float
    keys: Keys
    """On the way to its objects in the scene file."""


def _floor(container: Container) -> _Surface:
    return _Surface(
        "into the container",
        container.centre,
        container.inner_size,
        container.floor_height,
        ("objects",),
    )


def _top(table: SideTable, number: int) -> _Surface:
    """The part of a table top that its moving objects never leave."""
    (x, y), (wide, deep) = table.centre, table.size
    dx, dy = table.motion.along if table.motion else (0.0, 0.0)
    return _Surface(
        f"on {table.name}",
        (x - dx / 2.0, y - dy / 2.0),
        (wide - abs(dx), deep - abs(dy)),
        table.height,
        ("side_tables", number, "objects"),
    )


def _moving(obj: SimObject, table: SideTable) -> SimObject:
    """The object, moving if its table has a motion."""
    if (motion := table.motion) is not None:
        obj.motion = Motion(
            start=obj.pose.translation.copy(),
            along=np.array([*motion.along, 0.0]),
            period=motion.period_s,
            until=np.inf if motion.stop_s is None else motion.stop_s,
        )
    return obj


def _objects(
    wanted: Objects, surface: _Surface, before: int, rng: np.random.Generator
) -> list[SimObject]:
    """Objects side by side on a surface; their numbers go on from `before`."""
    widths = (wanted.width_mm[0] / 1000.0, wanted.width_mm[1] / 1000.0)
    masses = (wanted.mass_g[0] / 1000.0, wanted.mass_g[1] / 1000.0)
    names = fitting(OBJECT_CLASSES, wanted.kinds, widths)
    if wanted.count and not names:
        low, high = wanted.width_mm
        raise LayoutError(
            f"objects: no {' or '.join(wanted.kinds)} is {low:g} to {high:g} mm wide; "
            "widen width_mm or name other kinds",
            surface.keys,
        )
    for _ in range(_LAYOUTS):
        objects = [
            make_object(f"{name} {before + i + 1}", OBJECT_CLASSES[name], widths, masses, rng)
            for i, name in enumerate(rng.choice(names, wanted.count) if wanted.count else [])
        ]
        if _lay_out(objects, surface, rng):
            return objects
    raise LayoutError(
        f"objects: {wanted.count} do not fit {surface.name}; lower count or width_mm, "
        "or enlarge what they lie on",
        surface.keys,
    )


def _lay_out(objects: Sequence[SimObject], surface: _Surface, rng: np.random.Generator) -> bool:
    """Give every object a pose on a surface, the largest first; False if they do not fit."""
    laid: list[SimObject] = []
    for obj in sorted(objects, key=lambda o: -o.radius):
        if not any(_try_turned(obj, laid, surface, spread, rng) for spread in _SPREADS):
            return False
        laid.append(obj)
    return True


def _try_turned(
    obj: SimObject,
    laid: Sequence[SimObject],
    surface: _Surface,
    spread: float,
    rng: np.random.Generator,
) -> bool:
    """Turn an object at random, then try positions until it is clear of rim and others."""
    turn = exp3(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]))
    obj.pose = SE3(turn, np.zeros(3))
    x, y, up = np.eye(3)
    half = np.array(surface.size) / 2.0 - WALL_GAP - spread
    low = np.array([obj.reach(-x), obj.reach(-y)]) - half
    high = half - np.array([obj.reach(x), obj.reach(y)])
    if (low > high).any():
        return False
    height = surface.height + obj.reach(-up)
    for position in surface.centre + rng.uniform(low, high, (_POSITIONS, 2)):
        obj.pose = SE3(turn, np.array([*position, height]))
        if all(_apart(obj, other, GAP + spread) for other in laid):
            return True
    return False


def _apart(a: SimObject, b: SimObject, gap: float) -> bool:
    (x, y, _), (u, v, _) = a.pose.translation, b.pose.translation
    return hypot(x - u, y - v) > a.radius + b.radius + gap or all(
        separation(p, q)[0] >= gap for p in a.placed() for q in b.placed()
    )


def _container(container: Container) -> list[Geom]:
    """Pedestal, floor and four walls, in this order."""
    x, y = container.centre
    half_x, half_y = container.inner_size[0] / 2.0, container.inner_size[1] / 2.0
    thick, top = container.wall_thickness / 2.0, container.floor_height
    wall_z = top - thick + container.wall_height / 2.0
    tall = container.wall_height / 2.0 + thick
    outer_x, outer_y = half_x + 2.0 * thick, half_y + 2.0 * thick
    foot = top - 2.0 * thick
    return [
        _upright("pedestal", (x, y, foot / 2.0), (outer_x, outer_y, foot / 2.0), _STONE),
        _upright("container/floor", (x, y, top - thick), (outer_x, outer_y, thick), _PLASTIC),
        *(
            _upright("container/wall", (x + dx, y + dy, wall_z), (hx, hy, tall), _PLASTIC)
            for dx, dy, hx, hy in (
                (half_x + thick, 0.0, thick, outer_y),
                (-half_x - thick, 0.0, thick, outer_y),
                (0.0, half_y + thick, outer_x, thick),
                (0.0, -half_y - thick, outer_x, thick),
            )
        ),
    ]


def _table(table: Table, name: str) -> list[Geom]:
    x, y = table.centre
    half_x, half_y, thick, leg = table.size[0] / 2.0, table.size[1] / 2.0, 0.015, 0.025
    leg_half = table.height / 2.0 - thick
    return [
        _upright(f"{name}/top", (x, y, table.height - thick), (half_x, half_y, thick), _WOOD),
        *(
            _upright(
                f"{name}/leg",
                (x + sx * (half_x - leg), y + sy * (half_y - leg), leg_half),
                (leg, leg, leg_half),
                _WOOD,
            )
            for sx in (-1.0, 1.0)
            for sy in (-1.0, 1.0)
        ),
    ]


def _fixture(fixture: Fixture) -> Geom:
    x, y, z = fixture.size
    turn = exp3(np.array([0.0, 0.0, np.deg2rad(fixture.yaw_deg)]))
    pose = SE3(turn, np.array(fixture.centre))
    return Geom(Box((x / 2.0, y / 2.0, z / 2.0)), pose, fixture.name, _STONE)


def _upright(
    name: str, centre: tuple[float, float, float], half: tuple[float, float, float], colour: Colour
) -> Geom:
    return Geom(Box(half), SE3(np.eye(3), np.array(centre)), name, colour)
