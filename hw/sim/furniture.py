"""Furniture of a scene: its shapes, and what was moved from its place on the map."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from pinocchio import SE3, exp3

from config import suggest
from hw.sim.meshes import MeshError, convex_parts, fewer
from hw.sim.placement import LayoutError
from hw.sim.scene_schema import Container, Fixture, SceneError, SideTable, Table
from hw.sim.sim_object import Surface
from hw.sim.sim_world import World
from robots import Box, Colour, Geom, Plane

_FLOOR: Colour = (196, 190, 180)
_WOOD: Colour = (176, 136, 96)
_PLASTIC: Colour = (120, 150, 170)
_STONE: Colour = (150, 150, 150)


def furniture_shapes(
    container: Container | None, table: Table | None, side_tables: Sequence[SideTable]
) -> list[Geom]:
    """The shapes of floor, container and tables, in the world."""
    return [
        Geom(Plane(), SE3.Identity(), "floor", _FLOOR),
        *(_container(container) if container else ()),
        *(_table(table, "table") if table else ()),
        *(part for side in side_tables for part in _table(side, side.name)),
    ]


def _container(container: Container) -> list[Geom]:
    x, y = container.centre
    half_x, half_y = container.inner_size[0] / 2.0, container.inner_size[1] / 2.0
    thick, top = container.wall_thickness / 2.0, container.floor_height
    wall_z = top - thick + container.wall_height / 2.0
    tall = container.wall_height / 2.0 + thick
    outer_x, outer_y = half_x + 2.0 * thick, half_y + 2.0 * thick
    foot = top - 2.0 * thick
    walls = (
        (half_x + thick, 0.0, thick, outer_y),
        (-half_x - thick, 0.0, thick, outer_y),
        (0.0, half_y + thick, outer_x, thick),
        (0.0, -half_y - thick, outer_x, thick),
    )
    return [
        _box("pedestal", (x, y, foot / 2.0), (outer_x, outer_y, foot / 2.0), _STONE),
        _box("container/floor", (x, y, top - thick), (outer_x, outer_y, thick), _PLASTIC),
        *(
            _box("container/wall", (x + dx, y + dy, wall_z), (hx, hy, tall), _PLASTIC)
            for dx, dy, hx, hy in walls
        ),
    ]


def _table(table: Table, name: str) -> list[Geom]:
    x, y = table.centre
    half_x, half_y, thick, leg = table.size[0] / 2.0, table.size[1] / 2.0, 0.015, 0.025
    leg_half = table.height / 2.0 - thick
    legs = [
        (x + sx * (half_x - leg), y + sy * (half_y - leg), leg_half)
        for sx in (-1.0, 1.0)
        for sy in (-1.0, 1.0)
    ]
    return [
        _box(f"{name}/top", (x, y, table.height - thick), (half_x, half_y, thick), _WOOD),
        *(_box(f"{name}/leg", centre, (leg, leg, leg_half), _WOOD) for centre in legs),
    ]


def fixture_shapes(fixture: Fixture, number: int) -> tuple[list[Geom], list[Surface]]:
    """Collision shapes of a fixture, and its visual mesh if it has one; raises LayoutError."""
    turn = exp3(np.array([0.0, 0.0, np.deg2rad(fixture.yaw_deg)]))
    pose = SE3(turn, np.array(fixture.centre))
    if fixture.size is not None:
        x, y, z = fixture.size
        return [Geom(Box((x / 2.0, y / 2.0, z / 2.0)), pose, fixture.name, _STONE)], []
    try:
        mesh = fixture.read()
        parts = convex_parts(mesh, Path(fixture.mesh or "").name)
    except MeshError as error:
        text, keys = f"fixtures.{number}.mesh: {error}", ("fixtures", number, "mesh")
        raise LayoutError(text, keys) from error
    shapes = [Geom(part.shape, pose * part.pose, fixture.name, _STONE) for part in parts]
    return shapes, [Surface(fewer(mesh), pose, fixture.name, _STONE)]


NOTHING_MOVED: Mapping[str, Sequence[float]] = MappingProxyType({})


def with_moved(world: World, moved: Mapping[str, Sequence[float]]) -> World:
    """A new world with furniture moved by x, y [m] and a turn [deg], by name; raises SceneError."""
    pieces: dict[str, list[Geom]] = {}
    for one in world.fixtures:
        if not isinstance(one.shape, Plane):
            pieces.setdefault(one.piece, []).append(one)
    for name in moved:
        if name not in pieces:
            raise SceneError(f"moved: no furniture is called `{name}`; {suggest(name, pieces)}")
    motions = {name: _motion(pieces[name], *by) for name, by in moved.items()}
    still = SE3.Identity()

    def there(one: Geom) -> Geom:
        return one.moved(motions[one.piece]) if one.piece in motions else one

    surfaces = [
        replace(one, pose=motions.get(one.name, still) * one.pose) for one in world.surfaces
    ]
    for obj in world.objects:
        motion = motions.get(world.resting_on(obj), still)
        obj.pose = motion * obj.pose
        if (way := obj.motion) is not None:
            obj.motion = replace(
                way, start=motion.act(way.start), along=motion.rotation @ way.along
            )
    moved_world = World(
        [there(one) for one in world.fixtures], world.objects, world.walkers, surfaces=surfaces
    )
    moved_world.mapped = world.mapped
    return moved_world


def _motion(parts: Sequence[Geom], x: float, y: float, turn_deg: float) -> SE3:
    """The motion of a piece by x, y [m] and a turn [deg] about the middle of its parts."""
    centre = np.mean([part.pose.translation for part in parts], axis=0)
    rotation = exp3(np.array([0.0, 0.0, np.deg2rad(turn_deg)]))
    return SE3(rotation, centre + np.array([x, y, 0.0]) - rotation @ centre)


def _box(
    name: str, centre: tuple[float, float, float], half: tuple[float, float, float], colour: Colour
) -> Geom:
    return Geom(Box(half), SE3(np.eye(3), np.array(centre)), name, colour)
