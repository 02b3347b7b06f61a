"""Reads a URDF: xacro, checks whose errors are one line, meshes in packages, Pinocchio's models."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from math import hypot, isfinite
from pathlib import Path
from typing import Any, NamedTuple, NoReturn
from xml.etree import ElementTree

import pinocchio as pin

from config import UserError, counted, extra, quoted, suggest

_MOVING, _STILL = ("revolute", "continuous", "prismatic"), ("fixed", "floating", "planar")
_SPEEDS = {"revolute": 1.0, "continuous": 1.0, "prismatic": 0.1}  # if none is given [rad/s, m/s]
_EFFORT, _MOST_EFFORT = 50.0, 1e4  # if none is given, and what is believed [Nm, N]
_ENDLESS = 50.0  # a range this wide is none [rad]
_MOST = 1e12
_ABOVE = 4  # folders above a xacro file in which the packages that it names may lie
_SIZES = {"box": {"size": 3}, "sphere": {"radius": 1}, "cylinder": {"radius": 1, "length": 1}}
_ROS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")  # folders of packages, or above their `share`


class UrdfError(UserError):
    """A URDF that cannot be used; the text says what and what to do."""


class Mimic(NamedTuple):
    """A joint follows another: q = multiplier q_of + offset."""

    of: str
    multiplier: float
    offset: float


class Urdf:
    """A URDF with all its joints; `packages` are more folders in which its meshes lie.

    UrdfError: it cannot be used.
    """

    def __init__(self, path: Path, packages: Sequence[Path] = ()) -> None:
        self.path = path
        self._folders = [*packages, *path.resolve().parents]
        for one in filter(None, ":".join(os.environ.get(key, "") for key in _ROS).split(":")):
            self._folders += [Path(one), Path(one) / "share"]
        self.notes: list[str] = []  # what was not as expected, a line each
        self.parents: dict[str, str] = {}  # joint that holds a link, by the name of the link
        self.links: dict[str, tuple[str, str]] = {}  # parent and child of a joint, by its name
        self.kinds: dict[str, str] = {}  # of its moving joints
        self.mimics: dict[str, Mimic] = {}
        try:
            root = ElementTree.fromstring(_text(path, self._folders[: len(packages) + _ABOVE]))
        except (ElementTree.ParseError, ValueError) as error:
            self.refuse(f"no XML ({error})", "give a URDF, or a .xacro file")
        if root.tag != "robot":
            self.refuse(f"its first element is <{root.tag}>, not <robot>", "give a URDF")
        self.name = root.get("name") or path.stem
        self._check(root)
        text = ElementTree.tostring(root, encoding="unicode")
        try:
            self.model = pin.buildModelFromXML(text)
            self.geometry = pin.buildGeomFromUrdfString(
                self.model, text, pin.GeometryType.COLLISION
            )
        except Exception as error:  # of a parser of files that anybody may have made
            why = " ".join(str(error).split())[:150] or type(error).__name__
            self.refuse(f"Pinocchio cannot read it: {why}", "check it with `check_urdf`")

    def path_to(self, link: str) -> list[str]:
        """Joints from the root to a link, in their order."""
        found = []
        while link in self.parents:
            found.append(self.parents[link])
            link = self.links[found[-1]][0]
        return found[::-1]

    def joint(self, name: str) -> Any:
        """A joint of the model."""
        return self.model.joints[self.model.getJointId(name)]

    def refuse(self, what: str, hint: str) -> NoReturn:
        """Raise UrdfError."""
        raise UrdfError(f"{self.path}: {what}; {hint}") from None

    def _check(self, root: Any) -> None:
        """Refuse what cannot be used; make the rest one that Pinocchio understands."""
        for one in [one for one in root if one.tag not in ("link", "joint")]:
            root.remove(one)
        links = root.findall("link")
        for kind in ("link", "joint"):
            counts = Counter(one.get("name", "") for one in root.findall(kind))
            if "" in counts:
                self.refuse(f"a <{kind}> has no name", "give it one")
            if twice := [name for name, count in counts.items() if count > 1]:
                self.refuse(f"several {kind}s are called `{twice[0]}`", "give each its own name")
        names = [one.get("name") for one in links]
        for joint in root.findall("joint"):
            self._joint(joint, names)
        for link in links:
            self._link(link)
        roots = [name for name in names if name not in self.parents]
        if len(roots) > 1:
            what = f"{len(roots)} links have no parent ({quoted(roots[:4])})"
            self.refuse(what, "connect them by joints")
        for name in names:
            link, seen = name, set()
            while link in self.parents and link not in seen:
                seen.add(link)
                link = self.links[self.parents[link]][0]
            if link in seen:
                self.refuse(f"the links around `{link}` form a loop", "cut it at one joint")
        if not self.kinds:
            self.refuse("no joint in it moves", "give the URDF of a robot with an arm")
        self.root = roots[0]

    def _joint(self, joint: Any, links: list[str]) -> None:
        name, kind = joint.get("name"), joint.get("type", "")
        if kind not in (*_MOVING, *_STILL):
            self.refuse(f"joint `{name}` is of the type `{kind}`", suggest(kind, _MOVING))
        if kind in ("floating", "planar"):
            self.notes.append(f"joint `{name}` is {kind}: taken as fixed")
            joint.set("type", "fixed")
        ends = []
        for tag in ("parent", "child"):
            element = joint.find(tag)
            ends.append("" if element is None else element.get("link", ""))
            if ends[-1] not in links:
                what = f"the {tag} of joint `{name}` is `{ends[-1]}`, which is no link"
                self.refuse(what, suggest(ends[-1], links))
        parent, child = ends
        if child in self.parents:
            what = f"link `{child}` has two parents (joints `{self.parents[child]}`, `{name}`)"
            self.refuse(what, "cut the loop at one of them")
        self.parents[child], self.links[name] = name, (parent, child)
        self._pose(joint, f"joint `{name}`")
        if kind not in _MOVING:
            return
        axis = joint.find("axis")
        if axis is not None and hypot(*self._numbers(axis, "xyz", 3, f"joint `{name}`")) < 1e-6:
            self.refuse(f"the axis of joint `{name}` is zero", 'write for example xyz="0 0 1"')
        self._limit(joint, name, kind)
        mimic = joint.find("mimic")
        if mimic is not None:
            factors = (("multiplier", 1.0), ("offset", 0.0))
            numbers = [self._numbers(mimic, key, 1, name, one)[0] for key, one in factors]
            self.mimics[name] = Mimic(mimic.get("joint", ""), *numbers)
            joint.remove(mimic)  # all are read as joints

    def _limit(self, joint: Any, name: str, kind: str) -> None:
        """Bounds that can be used; what is missing is assumed, and told."""
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit")
        keys, where = ("lower", "upper", "velocity", "effort"), f"limit of joint `{name}`"
        low, high, speed, effort = (self._numbers(limit, key, 1, where, 0.0)[0] for key in keys)
        if low > high:
            self.refuse(f"{where}: {low:g} to {high:g}", "the lower bound comes first")
        if kind == "revolute" and (low == high or high - low > _ENDLESS):
            self.notes.append(f"joint `{name}` has no range: taken as continuous")
            kind = "continuous"
            joint.set("type", kind)
        if speed <= 0.0:
            speed = _SPEEDS[kind]
            self.notes.append(f"joint `{name}` has no speed limit: {speed:g} is assumed")
        effort = effort if 0.0 < effort < _MOST_EFFORT else _EFFORT
        for key, value in zip(keys, (low, high, speed, effort), strict=True):
            limit.set(key, repr(value))
        self.kinds[name] = kind

    def _link(self, link: Any) -> None:
        name = link.get("name")
        for visual in link.findall("visual"):
            link.remove(visual)
        for collision in link.findall("collision"):
            self._pose(collision, f"a collision shape of `{name}`")
            shapes = [*collision.iterfind("geometry/*")]
            if not shapes or not self._is_usable(shapes[0], f"a collision shape of `{name}`"):
                link.remove(collision)
        inertial = link.find("inertial")
        if inertial is not None:
            self._pose(inertial, f"inertia of `{name}`")
            for part in inertial.iter():
                for key in {"value", "ixx", "ixy", "ixz", "iyy", "iyz", "izz"} & set(part.keys()):
                    self._numbers(part, key, 1, f"inertia of `{name}`")

    def _is_usable(self, shape: Any, where: str) -> bool:
        for key, count in _SIZES.get(shape.tag, {}).items():
            if min(self._numbers(shape, key, count, where)) <= 0.0:
                self.refuse(f"{where}: its {key} is not positive", "write its full size")
        if shape.tag == "mesh":
            self._numbers(shape, "scale", 3, where, 1.0)
            told = shape.get("filename", "")
            if (found := self._mesh(told)) is None:
                self.notes.append(f"no mesh `{told}` (--packages FOLDER): left out")
                return False
            shape.set("filename", str(found))
        elif shape.tag not in _SIZES:
            self.notes.append(f"{where} is a <{shape.tag}>: left out")
        return shape.tag == "mesh" or shape.tag in _SIZES

    def _mesh(self, told: str) -> Path | None:
        """The file of a mesh, by its path or in a package."""
        scheme, found, rest = told.partition("://")
        if not found or scheme == "file":
            places = [self.path.parent / (rest or told)]
        else:
            inside = rest.partition("/")[2]
            places = [folder / one for folder in self._folders for one in (rest, inside)]
        return next((path.resolve() for path in places if path.is_file()), None)

    def _pose(self, element: Any, where: str) -> None:
        origin = element.find("origin")
        for key in () if origin is None else ("xyz", "rpy"):
            self._numbers(origin, key, 3, where, 0.0)

    def _numbers(
        self, element: Any, key: str, count: int, where: str, usual: float | None = None
    ) -> list[float]:
        words = element.get(key, "").split()
        if not words and usual is not None:
            return [usual] * count
        if len(words) != count:
            what = f"{where}: `{key}` has {counted(len(words), 'number')}, not {count}"
            self.refuse(what, "write them with spaces between")
        try:
            numbers = [float(word) for word in words]
        except ValueError:
            numbers = [float("nan")]
        if not all(isfinite(one) and abs(one) < _MOST for one in numbers):
            self.refuse(f"{where}: `{key}` is `{' '.join(words)}`", "write finite numbers")
        return numbers


def _text(path: Path, folders: list[Path]) -> str:
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UrdfError(f"{path}: cannot be read ({error}); check the path") from None
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise UrdfError(f"{path}: it declares entities; write them out")
    if path.suffix != ".xacro":
        return text
    try:
        from xacrodoc import XacroDoc
        from xacrodoc import packages as known
    except ImportError:
        raise UrdfError(f"xacro files need an extra: {extra('robots')}") from None
    inside = [one for folder in folders if folder.is_dir() for one in folder.iterdir()]
    known.look_in(folders)
    known.update_package_cache({one.name: str(one) for one in inside if one.is_dir()})
    try:
        return str(XacroDoc.from_file(str(path)).to_urdf_string())
    except (Exception, SystemExit) as error:  # xacro ends the process on some mistakes
        why = " ".join(str(error).split())[:200]
        hint = "or expand it yourself and give the URDF"
        raise UrdfError(f"{path}: xacro cannot expand it: {why}; {hint}") from None
