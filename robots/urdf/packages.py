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
        self._given = [one.resolve() for one in given]

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
        files = [one / inside for one in self.find(name) if (one / inside).is_file()]
        note = ""
        if not files:
            files = [one / inside for one in self.folders if (one / inside).is_file()][:1]
            note = (
                f"no package `{name}` has its meshes: those of {_folder(files, inside)} are taken"
            )
        elif not set(self._given) & set(files[0].parents):
            files = [one for one in files if one == files[0] or not cmp(files[0], one, False)]
            others = ", not ".join(_folder([one], inside) for one in files)
            near = {one.resolve() for one in self.folders}
            is_near = near & {Path(_folder(files, inside)), Path(_folder(files, inside)).parent}
            note = f"package `{name}`: taken is {others}" if files[1:] or not is_near else ""
        if files and note and f"{note} (--packages)" not in notes:
            notes.append(f"{note} (--packages)")
        return files[0].resolve() if files else None

    def _called(self, name: str) -> Iterator[Path]:
        for folder in self.folders:
            yield from (one for one in (folder, folder / name) if one.name == name)
            for below in _BELOW if folder in self._workspaces else ():
                manifests = _below(folder, below + "package.xml")
                yield from (one.parent for one in manifests if _declared(one.parent) == name)
                yield from _below(folder, below + escape(name))


def _folder(files: list[Path], inside: str) -> str:
    return str(files[0])[: -len(inside) - 1] if files else ""


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
