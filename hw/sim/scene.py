"""Scenes: find and read a scene file, and build its world."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from os.path import isfile
from pathlib import Path
from typing import TypeVar

import numpy as np
from pydantic import ValidationInfo, field_validator

from config import (
    LAYOUT,
    Diagnostic,
    Diagnostics,
    Location,
    YamlList,
    YamlMap,
    YamlValue,
    parted,
    quoted,
    read_yaml,
    suggest,
)
from config.reader import ConfigError, StrictModel, read_config, validate
from hw.sim.contact import Vicinity
from hw.sim.furniture import NOTHING_MOVED, fixture_shapes, furniture_shapes, with_moved
from hw.sim.placement import Area, LayoutError, place_objects
from hw.sim.scene_schema import (
    Container,
    Fixture,
    Footprint,
    Limited,
    Objects,
    ReadingContext,
    SceneError,
    SideTable,
    Table,
)
from hw.sim.scene_schema import Motion as _Motion
from hw.sim.scene_schema import Walker as _Walker
from hw.sim.sim_object import Motion, SimObject
from hw.sim.sim_world import World
from hw.sim.walker import Walker
from robots import Geom

SCENES = Path(__file__).parent / "scenes"

_Named = TypeVar("_Named", SideTable, _Walker)


class Scene(StrictModel):
    """A scene file."""

    description: str = ""
    container: Container | None = None
    table: Table | None = None
    side_tables: Limited[SideTable] = ()
    fixtures: Limited[Fixture] = ()
    walkers: Limited[_Walker] = ()
    objects: Objects = Objects()  # in the container

    @field_validator("side_tables", "walkers")
    @classmethod
    def _have_distinct_names(cls, items: tuple[_Named, ...]) -> tuple[_Named, ...]:
        names = [item.name for item in items]
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"two of them are called {quoted(sorted(twice))}; rename one")
        return items

    @field_validator("objects")
    @classmethod
    def _lie_in_a_container(cls, objects: Objects, info: ValidationInfo) -> Objects:
        if info.data.get("container", objects) is None:
            raise ValueError(
                "lie in a container, and there is none; add `container`, or write `objects` at a "
                "side table or a fixture"
            )
        return objects


def scene_names() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in SCENES.glob("*.yaml"))


def find_scene(scene: str | Path) -> Path:
    """The file of a scene that is given by path or name; SceneError: it is neither."""
    path = Path(scene)
    if isfile(path):
        return path
    shipped = SCENES / f"{scene}.yaml"
    if isfile(shipped):
        return shipped
    names = scene_names()
    raise SceneError(
        f"no scene is called `{scene}`; {suggest(str(scene), names)} "
        f"The shipped scenes are {quoted(names)}; the path of a scene file works too"
    )


def read_scene(scene: str | Path, footprint: Footprint | None = None) -> Scene:
    """Read and validate a scene; SceneError: there is none, or a mistake, as at the `footprint`."""
    try:
        path = find_scene(scene)
        return read_config(path, Scene, context=ReadingContext(path.parent, footprint))
    except ConfigError as error:
        raise SceneError(str(error)) from error


def load_scene(
    scene: str | Path,
    seed: int,
    footprint: Footprint | None = None,
    moved: Mapping[str, Sequence[float]] = NOTHING_MOVED,
) -> World:
    """The world that a scene describes, with furniture `moved` since the map; raises SceneError."""
    described = read_scene(scene, footprint)
    with _told(scene):
        world = build_world(described, np.random.default_rng(seed))
        return with_moved(world, moved) if moved else world


def load_fixtures(scene: str | Path, unmapped: bool = False) -> tuple[Geom, ...]:
    """The static shapes of a scene, as on a map; SceneError: there is none, or a mistake in it."""
    described = read_scene(scene)
    fixtures = furniture_shapes(described.container, described.table, described.side_tables)
    with _told(scene):
        for number, fixture in enumerate(described.fixtures):
            fixtures += fixture_shapes(fixture, number)[0] if fixture.on_map or unmapped else []
    return tuple(fixtures)


def scene_mistakes(path: Path, footprint: Footprint | None = None) -> list[Diagnostic]:
    """All mistakes in a scene file, in order, the start of the robot included with a footprint."""
    diagnostics, context = Diagnostics(path), ReadingContext(path.parent, footprint)
    read = read_yaml(diagnostics)
    scene = None if read is None else validate(read[1], Scene, diagnostics, context=context)
    if scene is not None:
        try:
            build_world(scene, np.random.default_rng(0))
        except LayoutError as error:
            return _mistakes(path, error)
    return diagnostics.in_order()


@contextmanager
def _told(scene: str | Path) -> Iterator[None]:
    """What does not fit in a scene is told with its place in the file: SceneError."""
    try:
        yield
    except LayoutError as error:
        raise SceneError("\n".join(map(str, _mistakes(find_scene(scene), error)))) from error


def _mistakes(path: Path, error: LayoutError) -> list[Diagnostic]:
    diagnostics = Diagnostics(path)
    if (read := read_yaml(diagnostics)) is not None:
        for one in error.all:
            message, hint = parted(str(one))
            diagnostics.error(LAYOUT, _location(read[1], one.keys), message, hint or "change it")
    return diagnostics.in_order()


def _location(value: YamlValue, keys: Sequence[str | int]) -> Location:
    """Location of an entry; keys that the file does not have are skipped."""
    location = value.location
    for key in keys:
        if isinstance(value, YamlMap) and key in value.entries:
            location, value = value.entries[str(key)].location, value.entries[str(key)].value
        elif isinstance(value, YamlList) and isinstance(key, int) and key < len(value.items):
            value = value.items[key]
            location = value.location
    return location


def build_world(scene: Scene, rng: np.random.Generator) -> World:
    """Build the world of a scene that was read; LayoutError: the objects do not fit."""
    fixtures = furniture_shapes(scene.container, scene.table, scene.side_tables)
    unmapped, surfaces = [], []
    for number, fixture in enumerate(scene.fixtures):
        shapes, visual = fixture_shapes(fixture, number)
        fixtures += shapes
        surfaces += visual
        unmapped += [] if fixture.on_map else shapes
    objects: list[SimObject] = []
    for area, wanted, motion in _areas(scene, Vicinity(fixtures)):
        placed = place_objects(wanted, area, len(objects), rng)
        for obj in placed:
            obj.motion = _motion(obj, motion)
        objects += placed
    walkers = [Walker(w.name, w.radius, w.height, w.way, w.speed) for w in scene.walkers]
    return World(fixtures, objects, walkers, unmapped, surfaces)


def _areas(scene: Scene, around: Vicinity) -> Iterator[tuple[Area, Objects, _Motion | None]]:
    """What carries objects, which, and how they move on it."""
    if (box := scene.container) is not None:
        name, keys = "into the container", ("objects",)
        area = Area(name, box.centre, box.inner_size, box.floor_height, keys, around)
        yield area, scene.objects, None
    for number, table in enumerate(scene.side_tables):
        yield _table_top(table, number, around), table.objects, table.motion
    for number, one in enumerate(scene.fixtures):
        if one.objects is not None and one.size is not None:
            top, where = one.centre[2] + one.size[2] / 2.0, ("fixtures", number, "objects")
            on = Area(f"on {one.name}", one.centre[:2], one.size[:2], top, where, around)
            yield on, one.objects, None


def _table_top(table: SideTable, number: int, around: Vicinity) -> Area:
    """The part of a table top that its moving objects never leave."""
    (x, y), (wide, deep) = table.centre, table.size
    dx, dy = table.motion.along if table.motion else (0.0, 0.0)
    return Area(
        f"on {table.name}",
        (x - dx / 2.0, y - dy / 2.0),
        (wide - abs(dx), deep - abs(dy)),
        table.height,
        ("side_tables", number, "objects"),
        around,
    )


def _motion(obj: SimObject, motion: _Motion | None) -> Motion | None:
    if motion is None:
        return None
    return Motion(
        start=obj.pose.translation.copy(),
        along=np.array([*motion.along, 0.0]),
        period=motion.period_s,
        until=np.inf if motion.stop_s is None else motion.stop_s,
        steady=motion.steady,
    )
