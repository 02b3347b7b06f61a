"""Build the world of a scene: fixtures at their poses, objects side by side on their surface."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pinocchio import SE3, exp3

from config import Diagnostic, Diagnostics, read_yaml, validate
from hw.sim.furniture import Container, Fixture, SideTable, Table
from hw.sim.laying import Area, LayoutError, lay_out
from hw.sim.mesh_file import Footprint, Reading
from hw.sim.meshes import MeshError, convex_parts, fewer
from hw.sim.scene import Scene, SceneError, location_of, place, read_scene
from hw.sim.sim_object import Motion, SimObject
from hw.sim.surface import Surface
from hw.sim.walker import Walker
from hw.sim.world import World
from robots import Box, Colour, Geom, Plane

_FLOOR: Colour = (196, 190, 180)
_WOOD: Colour = (176, 136, 96)
_PLASTIC: Colour = (120, 150, 170)
_STONE: Colour = (150, 150, 150)


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
        lines = (f"{place(scene, one.keys)}: {one}" for one in error.all)
        raise SceneError("\n".join(lines)) from error


def scene_mistakes(path: Path, footprint: Footprint | None = None) -> list[Diagnostic]:
    """All that is wrong with a scene file, in order.

    Args:
        path: the file.
        footprint: of the robot that starts in it; None leaves the start unchecked.
    """
    diagnostics = Diagnostics(path)
    read = read_yaml(diagnostics)
    if read is None:
        return diagnostics.in_order()
    scene = validate(read[1], Scene, diagnostics, context=Reading(path.parent, footprint))
    if scene is not None:
        try:
            build_world(scene, np.random.default_rng(0))
        except LayoutError as error:
            for one in error.all:
                message, _, hint = str(one).partition("; ")
                diagnostics.error(location_of(read[1], one.keys), message, hint or "change it")
    return diagnostics.in_order()


def build_world(scene: Scene, rng: np.random.Generator) -> World:
    """Build the world of a scene that was read.

    Raises:
        LayoutError: the objects cannot be made, or do not fit.
    """
    fixtures, unmapped, surfaces = _furniture(scene), [], []
    for number, fixture in enumerate(scene.fixtures):
        shapes, seen = _fixture(fixture, number)
        fixtures += shapes
        surfaces += seen
        unmapped += [] if fixture.on_map else shapes
    objects = lay_out(scene.objects, _floor(scene.container), 0, rng)
    for number, table in enumerate(scene.side_tables):
        lying = lay_out(table.objects, _top(table, number), len(objects), rng)
        objects += [_moving(obj, table) for obj in lying]
    walkers = [Walker(w.name, w.radius, w.height, w.way, w.speed) for w in scene.walkers]
    return World(fixtures, objects, walkers, unmapped, surfaces)


def load_fixtures(scene: str | Path, unmapped: bool = False) -> tuple[Geom, ...]:
    """What a scene says that stands around and never moves, as on a map.

    Args:
        scene: name of a shipped scene, or path of a scene file.
        unmapped: whether what is not on the map belongs to it too.

    Raises:
        SceneError: there is no such scene, or its file is not valid.
    """
    described = read_scene(scene)
    fixtures = _furniture(described)
    try:
        for number, fixture in enumerate(described.fixtures):
            fixtures += _fixture(fixture, number)[0] if fixture.on_map or unmapped else []
    except LayoutError as error:
        raise SceneError(f"{place(scene, error.keys)}: {error}") from error
    return tuple(fixtures)


def _furniture(scene: Scene) -> list[Geom]:
    """The floor, the container and all tables."""
    return [
        Geom(Plane(), SE3.Identity(), "floor", _FLOOR),
        *_container(scene.container),
        *_table(scene.table, "table"),
        *(part for table in scene.side_tables for part in _table(table, table.name)),
    ]


def _floor(container: Container) -> Area:
    return Area(
        "into the container",
        container.centre,
        container.inner_size,
        container.floor_height,
        ("objects",),
    )


def _top(table: SideTable, number: int) -> Area:
    """The part of a table top that its moving objects never leave."""
    (x, y), (wide, deep) = table.centre, table.size
    dx, dy = table.motion.along if table.motion else (0.0, 0.0)
    return Area(
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
            steady=motion.steady,
        )
    return obj


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


def _fixture(fixture: Fixture, number: int) -> tuple[list[Geom], list[Surface]]:
    """The shapes of a fixture, and what is seen of it if that is something else."""
    turn = exp3(np.array([0.0, 0.0, np.deg2rad(fixture.yaw_deg)]))
    pose = SE3(turn, np.array(fixture.centre))
    if fixture.size is not None:
        x, y, z = fixture.size
        return [Geom(Box((x / 2.0, y / 2.0, z / 2.0)), pose, fixture.name, _STONE)], []
    try:
        mesh = fixture.read()
        parts = convex_parts(mesh, Path(fixture.mesh or "").name)
    except MeshError as error:
        raise LayoutError(
            f"fixtures.{number}.mesh: {error}", ("fixtures", number, "mesh")
        ) from error
    shapes = [Geom(part.shape, pose * part.pose, fixture.name, _STONE) for part in parts]
    return shapes, [Surface(fewer(mesh), pose, fixture.name, _STONE)]


def _upright(
    name: str, centre: tuple[float, float, float], half: tuple[float, float, float], colour: Colour
) -> Geom:
    return Geom(Box(half), SE3(np.eye(3), np.array(centre)), name, colour)
