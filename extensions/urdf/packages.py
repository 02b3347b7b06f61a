"""Packages of ROS around a file: folders that are called so, or whose package.xml says so."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from filecmp import cmp
from functools import cache
from glob import escape
from pathlib import Path

_ABOVE = 4  # folders above a file in which packages may lie deeper, as in a workspace ...
_BELOW = ("", "*/", "*/*/")  # ... and where
_ROS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")  # folders of packages, or above their `share`
_NAME = re.compile(r"<name>\s*([^<\s]+)")


class Packages:
    """The packages in given folders, in those above a file, and in those that ROS knows."""

    def __init__(self, path: Path, given: Sequence[Path] = ()) -> None:
        above = path.resolve().parents
        self._workspaces = [*given, *above[: min(_ABOVE, len(above) - 1)]]
        self.folders = [*given, *above]  # in the order in which they are searched
        for one in filter(None, ":".join(os.environ.get(key, "") for key in _ROS).split(":")):
            self.folders += [Path(one), Path(one) / "share"]

    def find(self, name: str) -> list[Path]:
        """The folders of a package, the likely one first; what has the name of another is last."""
        found = dict.fromkeys(one.resolve() for one in self._called(name) if one.is_dir())
        return sorted(found, key=lambda one: _declared(one) not in ("", name))

    def mesh(self, told: str, notes: list[str]) -> Path | None:
        """The file of `package://NAME/PATH`; another than that of the one package is noted."""
        name, _, inside = told.partition("://")[2].partition("/")
        if name in ("", ".", ".."):
            places = [folder / name / inside for folder in self.folders]
            return next((one.resolve() for one in places if one.is_file()), None)
        homes = [one for one in self.find(name) if (one / inside).is_file()]
        near = {one.resolve() for one in self.folders}
        note = ""
        if not homes:
            homes = [one for one in self.folders if (one / inside).is_file()][:1]
            note = f"no package `{name}` has its meshes: those in {homes[0]}" if homes else ""
        else:
            first = homes[0] / inside
            homes = [one for one in homes if one == homes[0] or not cmp(first, one / inside, False)]
            if homes[1:] or not near & {homes[0], homes[0].parent}:
                note = f"package `{name}`: that in {', not '.join(map(str, homes))}"
        note += " (--packages)" if note else ""
        notes += [note] if note and note not in notes else []
        return (homes[0] / inside).resolve() if homes else None

    def _called(self, name: str) -> Iterator[Path]:
        for folder in self.folders:
            yield from (one for one in (folder, folder / name) if one.name == name)
            for below in _BELOW if folder in self._workspaces else ():
                manifests = _below(folder, below + "package.xml")
                yield from (one.parent for one in manifests if _declared(one.parent) == name)
                yield from _below(folder, below + escape(name))


@cache
def _below(folder: Path, pattern: str) -> list[Path]:
    return sorted(folder.glob(pattern))


@cache
def _declared(folder: Path) -> str:
    """The name that the package.xml of a folder says; empty if it has none."""
    try:
        said = _NAME.search((folder / "package.xml").read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return ""
    return said[1] if said else ""
