"""The folder that a model works in: nothing outside of it is read or written."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from os.path import isfile
from pathlib import Path
from tempfile import mkstemp

from config import Diagnostics, UserError, YamlList, YamlMap, YamlValue, quoted, read_yaml
from hw.sim import find_scene
from robots import load_real_robot, robot_names
from trees import shipped, shipped_names

PRODUCT = Path(__file__).parents[2]
_PLACES = "places.yaml"
_FILES = ("scene", "subtree", "file")  # keys of a task whose texts are files


class WorkspaceError(UserError):
    """What is asked for leads out of the folder, or moves a real robot."""


class Workspace:
    """The folder; its methods raise WorkspaceError."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()

    @contextmanager
    def task(self, task: str) -> Iterator[Path]:
        """The file of a task that is given by name; a text becomes a file for the context."""
        if ":" not in task:
            yield shipped(task) if task in shipped_names() else self._file(task)
            return
        number, name = mkstemp(dir=self.folder, prefix=".draft-", suffix=".yaml")
        try:
            with open(number, "wb") as file:
                file.write(task.encode(errors="replace"))
            yield self._file(Path(name).name)
        finally:
            Path(name).unlink(missing_ok=True)

    @property
    def places(self) -> Path | None:
        """The file that `teach` writes, if there is one: it holds for every task."""
        return self._file(_PLACES) if isfile(self.folder / _PLACES) else None

    def robot(self, robot: str) -> str:
        """The description of a robot."""
        if robot in robot_names():
            return robot
        path = self._file(robot)
        if load_real_robot(path) is not None:
            raise WorkspaceError(f"{robot}: is a real robot; name one of {quoted(robot_names())}")
        return str(path)

    def scene(self, scene: str) -> str:
        """The name or file of a scene, which is there; empty for none."""
        self._refuse_outside(scene, self.folder)
        if scene:
            find_scene(scene)
        return scene

    def scene_of(self, path: Path) -> str:
        """The scene that a task names; empty if it names none."""
        read = _read(path)
        entry = read.entries.get("scene") if isinstance(read, YamlMap) else None
        return next((text for _, text in _texts(entry.value)), "") if entry else ""

    def _file(self, name: str) -> Path:
        """A file, unless one that it names leads out of the folder."""
        self._refuse_outside(name, self.folder)
        path = self.folder / name
        if not isfile(path):
            raise WorkspaceError(f"{name[:80]!r}: no such file; give one, or the text of a task")
        read = _read(path)
        is_task = isinstance(read, YamlMap) and "tree" in read.entries
        for key, text in _texts(read):
            if key in _FILES or not (is_task or key == "description"):
                for folder in (self.folder, path.parent):
                    self._refuse_outside(text, folder)
        return path

    def _refuse_outside(self, text: str, folder: Path) -> None:
        """Refuse a text that leads out of our folder when it is read as a path below another."""
        try:
            is_inside = (folder / text).resolve().is_relative_to(self.folder)
        except (OSError, RuntimeError, ValueError):  # a loop of links, or no path at all
            is_inside = False
        if not is_inside or ".." in Path(text).parts:
            raise WorkspaceError(f"{text[:80]!r}: leads out of the folder; name what is in it")


def _read(path: Path) -> YamlValue | None:
    read = read_yaml(Diagnostics(path))
    return read[1] if read else None


def _texts(value: YamlValue | None, key: str = "") -> Iterator[tuple[str, str]]:
    """Every text of a file, and the innermost key above it."""
    if isinstance(value, YamlMap):
        for name, entry in value.entries.items():
            yield from _texts(entry.value, name)
    elif isinstance(value, YamlList):
        for item in value.items:
            yield from _texts(item, key)
    elif value is not None and isinstance(value.value, str):
        yield key, value.value
