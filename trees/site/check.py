"""All that is wrong with a task on a robot, in a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import radians
from os.path import isfile
from pathlib import Path
from typing import NamedTuple, TypeVar, cast

from behaviours import (
    ApproachWord,
    MapPlace,
    Region,
    ToolPose,
    region_at,
    region_direction,
    tilted_if_needed,
)
from config import Diagnostic, Diagnostics, Location, Severity, YamlMap, read_yaml, suggest
from robots import Geom, Plane, RobotDescription, load_real_robot, load_robot
from trees.language import (
    SCENE,
    KeyRead,
    LeafNode,
    NamedValue,
    SubtreeNode,
    Task,
    examine,
    leaves_at,
    nodes_below,
)
from trees.site import reachability as reach
from trees.site.site_rules import COME_TO, FURNITURE, REACH, SCENE_FILE, SET_DOWN, SURFACE
from trees.site.way import first_drives

_SMALL = 0.03  # a region with a shorter edge is smaller than what may stand in it [m]
_ANY_APPROACH: ApproachWord = "auto"
_T = TypeVar("_T")


class _Use(NamedTuple):
    """A place that a leaf is given."""

    path: Path  # of the file with the leaf
    leaf: LeafNode
    parameter: str
    value: NamedValue


def _leaves(task: Task) -> Iterator[tuple[Path, LeafNode]]:
    """Every leaf of a task and of its subtrees, and its file."""
    for node in nodes_below(task.root):
        yield from ((task.path, leaf) for leaf in leaves_at(node))
        if isinstance(node, SubtreeNode):
            yield from _leaves(node.task)


def _uses(task: Task) -> Iterator[_Use]:
    """Every place that a leaf of the task or of its subtrees is given and that is known by now."""
    for path, leaf in _leaves(task):
        for parameter, value in leaf.arguments.items():
            if isinstance(value, NamedValue):
                yield _Use(path, leaf, parameter, value)


def _definitions(task: Task) -> Iterator[tuple[NamedValue, Path, Location]]:
    """The places of a task and its subtrees, and where they are defined."""
    for name, value in (*task.poses.items(), *task.regions.items()):
        yield value, task.site.get(name, task.path), task.locations[name]
    for node in nodes_below(task.root):
        if isinstance(node, SubtreeNode):
            yield from _definitions(node.task)


def _is_scene(path: Path) -> bool:
    """Whether a file is a scene: it has keys of one, and none that a task needs."""
    read = read_yaml(Diagnostics(path))
    if read is None or not isinstance(read[1], YamlMap):
        return False
    keys = set(read[1].entries)
    if keys & {"task", "tree"}:
        return False
    from hw.sim import Scene

    return bool(keys & set(Scene.model_fields) - {"description"})


def scene_of(task: Task) -> str:
    """The scene that a task names: a path if the file is beside it, else as it is; or empty."""
    beside = task.path.parent / Path(task.scene)
    return str(beside) if task.scene and isfile(beside) else task.scene


def check(
    path: Path | str,
    *,
    places: Path | None = None,
    robot: str | Path = "frankie",
    text: str | None = None,
    scene: str = "",
) -> list[Diagnostic]:
    """Every diagnostic of a task file and its subtrees, in order: for a robot, in its own scene.

    Of a scene file, every diagnostic of that. `places` as for `load`, `text` as for `examine`;
    `robot` is a shipped one or a robot file. In another `scene`, unreachable places are warnings,
    as for `run`. Raises ConfigError: there is no such robot; SceneError: no such other scene, or a
    mistake in it; LeafError: a leaf class, not the file, is at fault.
    """
    task, found = examine(path, places=places, text=text)
    description, real = load_robot(robot), load_real_robot(robot)
    if task is None and _is_scene(Path(path)):
        from hw.sim import scene_mistakes

        return scene_mistakes(Path(path), description.base.size[:2])
    if task is None:
        return found
    on_map = real.map if real else None
    elsewhere = not on_map and scene not in ("", task.scene, scene_of(task))
    fixtures, mistakes = _furniture(task, description, on_map)
    if elsewhere:
        from hw.sim import load_fixtures

        fixtures = load_fixtures(scene, unmapped=True)
    found += mistakes + furniture_diagnostics(task, fixtures)
    found += place_diagnostics(task, description, () if elsewhere else fixtures)
    if elsewhere:
        there = place_diagnostics(task, description, fixtures)
        found += [replace(one, severity=Severity.WARNING) for one in there if one not in found]
    elif fixtures and not on_map:
        found += first_drives(task, description, fixtures)
    return _in_order(task, found)


def furniture_diagnostics(task: Task, fixtures: Sequence[Geom]) -> list[Diagnostic]:
    """Places of a task that are tied to furniture that is not on the map."""
    pieces = {one.piece for one in fixtures if not isinstance(one.shape, Plane)}
    return [
        Diagnostic(
            FURNITURE,
            path,
            location,
            f"`{place.name}`: no furniture is called `{place.on}`",
            suggest(place.on, pieces),
        )
        for place, path, location in _definitions(task)
        if pieces and isinstance(place, MapPlace) and place.on and place.on not in pieces
    ]


def place_diagnostics(
    task: Task, robot: RobotDescription, fixtures: Sequence[Geom] = ()
) -> list[Diagnostic]:
    """What is wrong with the places of a task.

    Places that are known only during the run are passed over. Without `fixtures` of the scene, in
    the world, only the robot counts.
    """
    defined = {id(value): (path, location) for value, path, location in _definitions(task)}
    uses = list(_uses(task))
    found = [
        diagnostic
        for use in uses
        for diagnostic in _of_use(use, defined.get(id(use.value)), robot, fixtures)
    ]
    if not robot.gripper.grasps:
        message, hint = f"`{robot.name}` has no gripper", "import it again with --gripper"
        found += [
            Diagnostic(COME_TO, use.path, use.leaf.location, message, hint)
            for use in uses
            if use.leaf.type.key == "grasp"
        ]
    if robot.stands_still:
        message, hint = f"the base of `{robot.name}` stands still", "leave out `drive`"
        found += [
            Diagnostic(REACH, path, leaf.location, message, hint)
            for path, leaf in _leaves(task)
            if leaf.type.key == "drive" and "to" not in leaf.arguments
        ]
    return list(dict.fromkeys([*found, *_not_set_down(uses, robot, fixtures)]))


def _not_set_down(
    uses: Sequence[_Use], robot: RobotDescription, fixtures: Sequence[Geom]
) -> Iterator[Diagnostic]:
    """Regions where things are to be set down by a hand that is tilted more than it grasps."""
    regions = (
        [(use, use.value) for use in uses if isinstance(use.value, Region)] if fixtures else []
    )
    if not regions:
        return
    grasps = [one for one in regions if one[0].leaf.type.key == "grasp"]
    solid = tuple(fixtures)
    ways = (region_direction(robot, solid, region, *_approach(use)) for use, region in grasps)
    tilts = [0.0 if way is None else way.tilt for way in ways]
    for use, region in regions:
        if use.leaf.type.key != "place":
            continue
        if (why := reach.why_not_set_down(region, robot, fixtures, tilts)) is not None:
            yield Diagnostic(SET_DOWN, use.path, use.leaf.location, *why, Severity.WARNING)


def _of_use(
    use: _Use,
    defined: tuple[Path, Location] | None,
    robot: RobotDescription,
    fixtures: Sequence[Geom],
) -> Iterator[Diagnostic]:
    leaf, value = use.leaf, use.value
    if defined is not None and use.parameter in leaf.type.goes_to:
        path, location = defined
        if isinstance(value, ToolPose):
            within = _given(use, "within_m", 0.0)
            value = tilted_if_needed(robot, tuple(fixtures), value, within)
        why = (
            reach.why_not_reached(value, robot)
            or reach.what_is_in_the_way(value, robot, fixtures)
            or reach.why_no_stance_is_free(value, robot, fixtures)
        )
        severity = Severity.ERROR
        if why is None and (why := reach.odd_pose(value, robot)):
            severity = Severity.WARNING
        if why is not None:
            message, hint = f"`{value.name}`: {why[0]}", why[1]
            yield Diagnostic(REACH, path, location, message, hint, severity)
    if use.parameter not in leaf.type.surfaces:
        return
    widths = (_given(use, name, 0.0) for name in leaf.type.opens_for)
    opening = 1000.0 * robot.gripper.opening
    if (wide := max(widths, default=0.0)) >= opening:
        message = f"`{leaf.name}` is for {wide:g} mm and more, and the fingers open to {opening:g}"
        yield Diagnostic(COME_TO, use.path, leaf.location, message, f"write less than {opening:g}")
    if isinstance(value, Region) and (width := value.size[:2].min()) < _SMALL:
        message = f"`{value.name}` is only {100.0 * width:.0f} cm wide"
        hint = "give it the size of the surface, in metres"
        yield Diagnostic(SURFACE, use.path, leaf.location, message, hint, Severity.WARNING)
    is_point = isinstance(value, ToolPose)
    if isinstance(value, ToolPose):
        value = region_at(value)
    if not isinstance(value, Region):
        return
    counts = bool(fixtures) or robot.stands_still
    if counts and (why := reach.why_not_come_to(value, robot, fixtures, *_approach(use))):
        yield Diagnostic(COME_TO, use.path, leaf.location, *why)
    if fixtures:
        sets_down = leaf.type.hand_after == "empty"
        bare = reach.bare_places(value, _given(use, "pitch_m", None), fixtures, sets_down)
        if bare.missing:
            message = (
                f"{bare.missing} of the {bare.of} places on `{value.name}` have no surface "
                f"of the scene under them, the nearest is {bare.nearest:.2f} m away"
            )
            hint = f"move `{value.name}`; things stand on its bottom face"
            hint = f"give `{value.name}` the height of the surface" if is_point else hint
            is_certain = bare.missing == bare.of and bare.nearest > reach.NEAR
            severity = Severity.ERROR if is_certain else Severity.WARNING
            yield Diagnostic(SURFACE, use.path, leaf.location, message, hint, severity)


def _approach(use: _Use) -> tuple[ApproachWord, float]:
    """How the hand may come to a region: the word, and the least tilt [rad]."""
    return _given(use, "approach", _ANY_APPROACH), radians(_given(use, "least_tilt_deg", 0.0))


def _given(use: _Use, name: str, otherwise: _T) -> _T:
    """A parameter of a leaf, or its default; `otherwise` where it has none, or not yet a value."""
    parameter = use.leaf.type.parameters.get(name)
    given = use.leaf.arguments.get(name, parameter and parameter.default)
    is_value = given is not None and not isinstance(given, KeyRead)
    return cast(_T, given) if is_value else otherwise


def _furniture(
    task: Task, robot: RobotDescription, on_map: str | None
) -> tuple[Sequence[Geom], list[Diagnostic]]:
    """What stands on the map, else in the scene that a task names, and what is wrong with that."""
    if not on_map and not task.scene:
        return (), []
    from hw.sim import SceneError, find_scene, load_fixtures, scene_mistakes

    if on_map:
        return load_fixtures(on_map), []
    location = task.locations[SCENE]
    try:
        path = find_scene(scene_of(task))
    except SceneError as error:
        message, _, hint = str(error).partition("; ")
        hint = f"write `{task.scene.replace(chr(92), '/')}`" if "\\" in task.scene else hint
        return (), [Diagnostic(SCENE_FILE, task.path, location, message, hint)]
    if mistakes := scene_mistakes(path, robot.base.size[:2]):
        message, hint = f"the scene `{task.scene}` has mistakes", "correct them there"
        return (), [Diagnostic(SCENE_FILE, task.path, location, message, hint), *mistakes]
    return load_fixtures(path, unmapped=True), []


def _in_order(task: Task, found: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Those of the file of the task first."""

    def order(one: Diagnostic) -> tuple[bool, Path, int, int]:
        line, column = (one.location.line, one.location.column) if one.location else (0, 0)
        return one.path != task.path, one.path, line, column

    return sorted(found, key=order)
