"""What can be started: tasks with their parameters and mistakes; robots, worlds and scenes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from app.core import DEFAULT_SCENE
from app.live import SceneView
from behaviours import Region
from config import Diagnostic, Severity, UserError, written
from extensions.page.control_page import Told
from extensions.page.plan import Plan
from hw import world_names
from hw.sim import load_fixtures, scene_names
from robots import robot_names
from trees import shipped, shipped_names
from trees.language import Task, TaskFileError, TaskParameter, examine, load
from trees.site import check

_TASK = re.compile(r"^task:", re.MULTILINE)


def task_files(folder: Path) -> dict[str, Path]:
    """The task files of a folder by their names in it, then the shipped tasks by theirs."""
    own = {path.name: path for path in sorted(folder.glob("*.yaml")) if _is_task(path)}
    return own | {name: shipped(name) for name in shipped_names()}


def catalogue(folder: Path) -> Told:
    """All that a person may choose from, for JSON."""
    return {
        "folder": str(folder.resolve()),
        "tasks": [_described(name, path) for name, path in task_files(folder).items()],
        "robots": robot_names(),
        "worlds": world_names(),
        "scenes": scene_names(),
    }


def mistakes(path: Path, robot: str, parameters: Mapping[str, str], scene: str = "") -> list[Told]:
    """The mistakes in a task for a robot, in a scene, and with values of its parameters.

    Each has its line of the file, or the `field` of the form that it is in.
    """
    told: list[Told] = []
    found: list[Diagnostic] = []
    for field, read in (
        ("robot", lambda: found.extend(check(path, robot=robot))),
        ("scene", lambda: load_fixtures(scene or DEFAULT_SCENE)),
    ):
        try:
            read()
        except UserError as error:
            told.append(at_field(field, str(error)))
    wrong = _refused(path, parameters)
    for name in parameters if wrong else ():
        others = _refused(path, {key: one for key, one in parameters.items() if key != name})
        texts = [f"{one.message}; {one.hint}" for one in wrong if one not in others]
        told += [at_field(f"parameters.{name}", text) for text in texts]
        wrong = [one for one in wrong if one in others]
    return [*told, *map(_shown, dict.fromkeys([*found, *wrong]))]


def _refused(path: Path, parameters: Mapping[str, str]) -> list[Diagnostic]:
    """What is wrong with a task with values of its parameters."""
    try:
        load(path, overrides=parameters)
    except TaskFileError as error:
        return list(error.diagnostics)
    return []


def at_field(field: str, text: str) -> Told:
    """A mistake in a field of the form."""
    return {"text": text, "severity": Severity.ERROR.value, "field": field}


def _is_task(path: Path) -> bool:
    try:
        return bool(_TASK.search(path.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return False


def _described(name: str, path: Path) -> Told:
    task, found = examine(path)
    parameters = {} if task is None else task.parameters
    return {
        "name": name,
        "description": "" if task is None else task.description,
        "scene": "" if task is None else task.scene,
        "bad": any(one.severity is Severity.ERROR for one in found),
        "parameters": [_field(key, one) for key, one in parameters.items()],
        "picture": "" if task is None else _picture(task),
    }


def _picture(task: Task) -> str:
    """Furniture and regions as SVG, seen from above; empty if there are none."""
    with suppress(UserError, ValueError):  # a scene with a mistake, or an empty one
        regions = tuple(one for one in task.regions.values() if isinstance(one, Region))
        fixtures = load_fixtures(task.scene or DEFAULT_SCENE)
        plan = Plan(SceneView(fixtures=fixtures, regions=regions), ())
        return f'<svg class="plan" viewBox="{plan.view_box()}">{plan.fixed}</svg>'
    return ""


def _field(name: str, parameter: TaskParameter) -> Told:
    """A parameter as a field of a form."""
    default = "" if parameter.default is None else written(parameter.default.value)
    field: Told = {"name": name, "description": parameter.description, "default": default}
    if (kind := parameter.type) is None:
        return field
    choices = [*map(written, kind.choices), *(["true", "false"] * (bool in kind.types))]
    field |= {"type": str(kind), "choices": choices}
    if kind.is_number and not choices:
        least = kind.least if kind.above is None else kind.above
        step = "any" if float in kind.types else "1"
        field |= {"step": step, "min": least, "max": kind.most}
    return field


def _shown(one: Diagnostic) -> Told:
    """A mistake, and the line of the file that it is in."""
    source = ""
    if one.location is not None:
        lines = one.path.read_text(encoding="utf-8").splitlines()
        line, column = one.location.line, one.location.column
        source = f"{line:4}  {lines[line - 1]}\n{' ' * (5 + column)}^"
    text = str(one).removeprefix(f"{one.path.parent}/")
    return {"text": text, "severity": one.severity.value, "source": source}
