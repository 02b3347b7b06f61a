"""The house: imports look down only, other rooms are entered by their face, files stay short."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]

CORE = (
    "config",
    "config.arrays",
    "config.planar",
    "config.poses",
    "config.reader",
    "robots",
    "controller",
    "perception",
    "perception.registration",
    "hw.system",
    "hw.claims",
    "hw.clock",
    "hw",
    "hw.sim",
    "hw.sim.objects",
    "hw.hardware",
    "behaviours",
    "trees.words",
    "trees.language",
    "trees.site",
    "trees",
    "trees.draw",
    "app.choices",
    "app.run_options",
    "app.terminal",
    "app.task_time",
    "app.web",
    "app.live",
    "app.core",
    "app.review",
    "app.authoring",
    "app.commands",
    "app",
    "frankie_task",
)
DRIVERS = ("drivers.processes", "drivers.omron", "drivers.panda", "drivers.realsense")
EXTENSIONS = tuple(
    f"extensions.{path.parent.name}" for path in sorted(ROOT.glob("extensions/*/__init__.py"))
)
LAB = (
    *("lab.shared", "lab.grasps", "lab.bench", "lab.calibration", "lab.film", "lab.commands"),
    "lab",
)
APART = ("extensions.physics.floating_hand", "extensions.ros2.sensing")
ROOMS = (*CORE, *DRIVERS, "drivers", "extensions", *EXTENSIONS, *APART, *LAB, "frankie_task_cli")
"""From the bottom up: a room may use those before it, by the names in its `__init__.py`.

A module is a room of its own where the package around it has to be quick to import."""

LEVEL = {room: level for level, room in enumerate(ROOMS)}
SIDE_BY_SIDE = {
    frozenset(pair)
    for pair in (
        ("controller", "perception"),
        ("trees.draw", "extensions.export.btcpp"),
        ("drivers.omron", "extensions.emulators.omron"),
        ("lab.grasps", "lab.calibration"),
        ("lab.bench", "lab.calibration"),
        *combinations(DRIVERS[1:], 2),
        *combinations(EXTENSIONS, 2),
    )
}
"""Rooms of one floor, which do not know each other."""
BY_FILE = ("drivers.processes",)
"""Rooms whose modules run in processes that import no face."""
LONGEST = 400

FILES = sorted(
    path
    for top in {room.partition(".")[0] for room in ROOMS}
    for path in (
        [ROOT / f"{top}.py"] if (ROOT / f"{top}.py").is_file() else (ROOT / top).rglob("*.py")
    )
    if not path.is_relative_to(ROOT / "extensions") or "tests" not in path.parts
)


class Import(NamedTuple):
    """One import of a room of ours."""

    place: str
    importer: str
    imported: str
    module: str


def room_of(module: str) -> str | None:
    """The innermost room that a module is in."""
    parts = module.split(".")
    candidates = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((name for name in candidates if name in LEVEL), None)


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in FILES}


@cache
def exports(module: str) -> frozenset[str]:
    """The names that the face of a package of ours imports, at once or when they are asked for."""
    faces = [one for one in (module, f"{module}.face") if one in MODULES]
    found = [node for one in faces for node in ast.walk(tree_of(MODULES[one]))]
    return frozenset(
        alias.name for node in found if isinstance(node, ast.ImportFrom) for alias in node.names
    )


@cache
def tree_of(path: Path) -> ast.Module:
    """What stands in a file; every test looks at all of them."""
    return ast.parse(path.read_text(encoding="utf-8"))


def modules_imported(node: ast.AST) -> Iterator[str]:
    """The modules that a statement imports; of `from package import module` the module."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            # A name that a face exports may be that of a module behind it.
            is_module = inner in MODULES and alias.name not in exports(node.module)
            yield inner if is_module else node.module


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """A node, and the statements inside it; expressions are left out."""
    yield node
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        for inner in getattr(node, field, ()):
            yield from statements(inner)


@cache
def imports() -> tuple[Import, ...]:
    found = []
    for name, path in MODULES.items():
        importer = room_of(name)
        assert importer is not None
        for node in statements(tree_of(path)):
            for module in modules_imported(node):
                if (imported := room_of(module)) is not None:
                    place = f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"
                    found.append(Import(place, importer, imported, module))
    return tuple(found)


def test_imports_only_look_down():
    up = [
        f"{one.place}: {one.importer} imports {one.module}"
        for one in imports()
        if one.imported != one.importer
        and (
            LEVEL[one.imported] > LEVEL[one.importer]
            or frozenset((one.imported, one.importer)) in SIDE_BY_SIDE
        )
        # A room may hand on what a room inside it has, and is imported with it.
        and not one.imported.startswith(f"{one.importer}.")
    ]
    assert up == []


def test_rooms_are_entered_by_their_face():
    deep = [
        f"{one.place}: {one.importer} imports {one.module}"
        for one in imports()
        if one.imported != one.importer
        and one.module != one.imported
        and one.imported not in BY_FILE
        # A room inside another shares the modules of the one around it.
        and not one.importer.startswith(f"{one.imported}.")
    ]
    assert deep == []


def test_no_name_that_a_face_imports_late_is_also_that_of_a_module():
    """Whoever imports the module first would get it instead."""
    late = [module.removesuffix(".face") for module in MODULES if module.endswith(".face")]
    assert late
    assert [
        f"{room}.{name}" for room in late for name in exports(room) if f"{room}.{name}" in MODULES
    ] == []


def test_there_is_no_circle_between_modules():
    graph: dict[str, set[str]] = {module: set() for module in MODULES}
    for module, path in MODULES.items():
        for node in tree_of(path).body:  # what is imported inside a function comes later
            graph[module] |= {m for m in modules_imported(node) if m in graph}
    done: set[str] = set()

    def circle_from(module: str, path: tuple[str, ...]) -> tuple[str, ...] | None:
        if module in path:
            return (*path[path.index(module) :], module)
        if module in done:
            return None
        for inner in sorted(graph[module]):
            if found := circle_from(inner, (*path, module)):
                return found
        done.add(module)
        return None

    circles = [circle for module in graph if (circle := circle_from(module, ()))]
    assert circles == []


def test_nothing_is_printed_past_the_terminal_that_makes_text_visible():
    consoles = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in FILES
        if "Console" in path.read_text(encoding="utf-8")
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "Console"
    ]
    assert consoles == []


def test_every_file_is_short_enough_to_be_one_idea():
    files = [*FILES, *(ROOT / "tests").rglob("*.py")]
    lines = {str(path): len(path.read_text(encoding="utf-8").splitlines()) for path in files}
    assert {path: count for path, count in lines.items() if count > LONGEST} == {}
