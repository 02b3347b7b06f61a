"""Putting a scene together: fixtures where it says, objects side by side in the container."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from pathlib import Path

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.contact import separation
from hw.sim.kinds import KINDS, fitting, make_object
from hw.sim.objects import SimObject
from hw.sim.scene import Container, Fixture, Scene, SceneError, Table, read_scene
from hw.sim.shapes import Box, Colour, Placed, Plane
from hw.sim.world import World

GAP = 0.006
"""Objects lie at least this far apart [m] ..."""

WALL_GAP = 0.022
"""... and this far from the walls of the container, where a finger just fits between [m]."""

_SPREADS = np.repeat([0.035, 0.025, 0.015, 0.008, 0.0, 0.0], 6)
"""Wished for in addition to either gap, one for each way that an object is turned [m]."""

_PLACES = 10
"""Tried for each."""

_LAYOUTS = 30
"""Tried, each with other objects, before giving up."""

_FLOOR: Colour = (196, 190, 180)
_WOOD: Colour = (176, 136, 96)
_PLASTIC: Colour = (120, 150, 170)
_STONE: Colour = (150, 150, 150)


def load_scene(scene: str | Path, seed: int) -> World:
    """The world that a scene describes.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        seed: of the objects and where they lie; the same seed gives the same world.

    Raises:
        SceneError: there is no such scene, or it is not a good one.
    """
    described = read_scene(scene)
    try:
        return build_world(described, np.random.default_rng(seed))
    except SceneError as error:
        raise SceneError(f"{scene}: {error}") from error


def build_world(scene: Scene, rng: np.random.Generator) -> World:
    """Everything that a scene says, put in its place.

    Raises:
        SceneError: the objects that it asks for cannot be made, or do not fit into the container.
    """
    fixtures = [
        Placed(Plane(), SE3.Identity(), "floor", _FLOOR),
        *_container(scene.container),
        *_table(scene.table),
        *(_fixture(f) for f in scene.fixtures),
    ]
    return World(fixtures, _objects(scene, rng))


def _objects(scene: Scene, rng: np.random.Generator) -> list[SimObject]:
    wanted = scene.objects
    widths = (wanted.width_mm[0] / 1000.0, wanted.width_mm[1] / 1000.0)
    masses = (wanted.mass_g[0] / 1000.0, wanted.mass_g[1] / 1000.0)
    kinds = fitting(KINDS, wanted.kinds, widths)
    if wanted.count and not kinds:
        low, high = wanted.width_mm
        raise SceneError(
            f"objects: none of {', '.join(wanted.kinds)} comes {low:g} to {high:g} mm wide: "
            "widen width_mm or name other kinds"
        )
    for _ in range(_LAYOUTS):
        objects = [
            make_object(f"{kind} {i + 1}", KINDS[kind], widths, masses, rng)
            for i, kind in enumerate(rng.choice(kinds, wanted.count) if wanted.count else [])
        ]
        if _lay_out(objects, scene.container, rng):
            return objects
    raise SceneError(
        f"objects: {wanted.count} do not fit into the container: lower count or width_mm, "
        "or enlarge container.inner_size"
    )


def _lay_out(objects: Sequence[SimObject], container: Container, rng: np.random.Generator) -> bool:
    """Give every object a place in the container, the largest first; False if it is full."""
    laid: list[SimObject] = []
    for thing in sorted(objects, key=lambda o: -o.radius):
        if not any(_try_turned(thing, laid, container, spread, rng) for spread in _SPREADS):
            return False
        laid.append(thing)
    return True


def _try_turned(
    thing: SimObject,
    laid: Sequence[SimObject],
    container: Container,
    spread: float,
    rng: np.random.Generator,
) -> bool:
    """Turn an object any way, and try places until it lies clear of the walls and of others."""
    turn = exp3(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]))
    thing.pose = SE3(turn, np.zeros(3))
    x, y, up = np.eye(3)
    half = np.array(container.inner_size) / 2.0 - WALL_GAP - spread
    low = np.array([thing.reach(-x), thing.reach(-y)]) - half
    high = half - np.array([thing.reach(x), thing.reach(y)])
    if (low > high).any():
        return False
    height = container.floor_height + thing.reach(-up)
    for place in container.centre + rng.uniform(low, high, (_PLACES, 2)):
        thing.pose = SE3(turn, np.array([*place, height]))
        if all(_apart(thing, other, GAP + spread) for other in laid):
            return True
    return False


def _apart(a: SimObject, b: SimObject, gap: float) -> bool:
    (x, y, _), (u, v, _) = a.pose.translation, b.pose.translation
    return hypot(x - u, y - v) > a.radius + b.radius + gap or all(
        separation(p, q)[0] >= gap for p in a.placed() for q in b.placed()
    )


def _container(container: Container) -> list[Placed]:
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


def _table(table: Table) -> list[Placed]:
    x, y = table.centre
    half_x, half_y, thick, leg = table.size[0] / 2.0, table.size[1] / 2.0, 0.015, 0.025
    leg_half = table.height / 2.0 - thick
    return [
        _upright("table/top", (x, y, table.height - thick), (half_x, half_y, thick), _WOOD),
        *(
            _upright(
                "table/leg",
                (x + sx * (half_x - leg), y + sy * (half_y - leg), leg_half),
                (leg, leg, leg_half),
                _WOOD,
            )
            for sx in (-1.0, 1.0)
            for sy in (-1.0, 1.0)
        ),
    ]


def _fixture(fixture: Fixture) -> Placed:
    x, y, z = fixture.size
    turn = exp3(np.array([0.0, 0.0, np.deg2rad(fixture.yaw_deg)]))
    pose = SE3(turn, np.array(fixture.centre))
    return Placed(Box((x / 2.0, y / 2.0, z / 2.0)), pose, fixture.name, _STONE)


def _upright(
    name: str, centre: tuple[float, float, float], half: tuple[float, float, float], colour: Colour
) -> Placed:
    return Placed(Box(half), SE3(np.eye(3), np.array(centre)), name, colour)
