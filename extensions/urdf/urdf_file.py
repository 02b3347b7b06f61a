"""Reads a URDF: xacro, checks whose errors are one line, meshes in packages, Pinocchio's models."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from math import hypot, inf
from pathlib import Path
from typing import Any, NamedTuple, NoReturn
from xml.etree import ElementTree

import pinocchio as pin

from config import UserError, counted, quoted, suggest
from extensions.urdf.packages import Packages
from extensions.urdf.xacro_file import expanded

_MOVING, _STILL = ("revolute", "continuous", "prismatic"), ("fixed", "floating", "planar")
_SPEEDS = {"revolute": 1.0, "continuous": 1.0, "prismatic": 0.1}  # if none is given [rad/s, m/s]
_EFFORT, MOST_EFFORT = 50.0, 1e4  # if none is given, and what is believed [Nm, N]
_FASTEST = 50.0  # what is believed [rad/s, m/s]
_ENDLESS = 1500.0  # a range this wide is none [rad]
_MOST = 1e12
OF_JOINT = ".joint"  # in Pinocchio's model, after the name of a joint that a link has too
_SIZES = {"box": {"size": 3}, "sphere": {"radius": 1}, "cylinder": {"radius": 1, "length": 1}}


class UrdfError(UserError):
    """A URDF that cannot be used; the text says what and what to do."""


class Mimic(NamedTuple):
    """A joint follows another: q = multiplier q_of + offset."""

    of: str
    multiplier: float
    offset: float


class Urdf:
    """A URDF with all its joints; `packages` are more folders in which its meshes lie.

    `arguments` are those of a xacro file, `name:=value`. UrdfError: it cannot be used.
    """

    def __init__(
        self, path: Path, packages: Sequence[Path] = (), arguments: Sequence[str] = ()
    ) -> None:
        self.path = path
        self._packages = Packages(path, packages)
        self.notes: list[str] = []  # what was not as expected, a line each
        self.parents: dict[str, str] = {}  # joint that holds a link, by the name of the link
        self.links: dict[str, tuple[str, str]] = {}  # parent and child of a joint, by its name
        self.kinds: dict[str, str] = {}  # of its moving joints
        self.mimics: dict[str, Mimic] = {}
        self.strong: set[str] = set()  # joints whose effort limit is believed
        self._written = ""  # the text, if its lines are those of the file
        try:
            root = ElementTree.fromstring(self._text(packages, arguments))
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
        """Raise UrdfError, with the line of what is named first."""
        what = what.replace(OF_JOINT, "")
        named = re.search("`([^`]+)`", what)
        said = named and re.search(f"name=[\"']{re.escape(named[1])}[\"']", self._written)
        line = f":{self._written.count(chr(10), 0, said.start()) + 1}" if said else ""
        raise UrdfError(f"{self.path}{line}: {what}; {hint}") from None

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
        for one in root.findall("joint") + root.findall("joint/mimic"):  # Pinocchio mixes them up
            key = "name" if one.tag == "joint" else "joint"
            if one.get(key) in names:
                one.set(key, f"{one.get(key)}{OF_JOINT}")
        if root.find("link/collision") is None and (drawn := root.findall("link/visual")):
            self.notes.append("no collision shapes: the shapes that are drawn are taken for them")
            for visual in drawn:
                visual.tag = "collision"
        for joint in root.findall("joint"):
            self._joint(joint, names)
        for link in links:
            self._link(link)
        self.mimics = {name: self._followed(name) for name in self.mimics}
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

    def _followed(self, name: str) -> Mimic:
        """What a joint mimics in the end, through those that mimic themselves."""
        of, multiplier, offset = self.mimics[name]
        seen = [name]
        while of in self.mimics and of not in seen:
            seen.append(of)
            before = self.mimics[of]
            of, offset = before.of, offset + multiplier * before.offset
            multiplier *= before.multiplier
        if of in seen:
            what = f"joint `{name}` mimics itself ({' -> '.join([*seen, of])})"
            self.refuse(what, "let one of them move on its own")
        if of not in self.links:
            what = f"joint `{name}` mimics `{of}`, which is no joint"
            self.refuse(what, suggest(of, self.links))
        return Mimic(of, multiplier, offset)

    def _limit(self, joint: Any, name: str, kind: str) -> None:
        """Bounds that can be used; what is missing is assumed, and told."""
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit")
        keys, where = ("lower", "upper", "velocity", "effort"), f"limit of joint `{name}`"
        told = (self._numbers(limit, key, 1, where, 0.0, most=inf)[0] for key in keys)
        low, high, speed, effort = told
        low, high = max(low, -_MOST), min(high, _MOST)
        if low > high:
            self.refuse(f"{where}: {low:g} to {high:g}", "the lower bound comes first")
        if kind == "revolute" and (low == high or high - low > _ENDLESS):
            self.notes.append(f"joint `{name}` has no range: taken as continuous")
            kind = "continuous"
            joint.set("type", kind)
        if not 0.0 < speed <= _FASTEST:
            why = f"a speed limit of {speed:g}, not believed" if speed > 0.0 else "no speed limit"
            speed = _SPEEDS[kind]
            self.notes.append(f"joint `{name}` has {why}: {speed:g} is assumed")
        if 0.0 < effort < MOST_EFFORT:
            self.strong.add(name)
        effort = effort if name in self.strong else _EFFORT
        for key, value in zip(keys, (low, high, speed, effort), strict=True):
            limit.set(key, repr(value))
        self.kinds[name] = kind

    def _link(self, link: Any) -> None:
        name = link.get("name")
        for other in [one for one in link if one.tag not in ("collision", "inertial")]:
            link.remove(other)
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
            if 0.0 in self._numbers(shape, "scale", 3, where, 1.0):
                self.notes.append(f"{where} has a scale of zero: left out")
                return False
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
        if found and scheme != "file":
            return self._packages.mesh(told, self.notes)
        path = self.path.parent / (rest or told)
        return path.resolve() if path.is_file() else None

    def _pose(self, element: Any, where: str) -> None:
        origin = element.find("origin")
        for key in () if origin is None else ("xyz", "rpy"):
            self._numbers(origin, key, 3, where, 0.0)

    def _numbers(
        self,
        element: Any,
        key: str,
        count: int,
        where: str,
        usual: float | None = None,
        most: float = _MOST,
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
        if not all(abs(one) <= most for one in numbers):
            hint = f"write numbers below {_MOST:g}"
            self.refuse(f"{where}: `{key}` is `{' '.join(words)}`", hint)
        return numbers

    def _text(self, packages: Sequence[Path], arguments: Sequence[str]) -> str:
        path = self.path
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise UrdfError(f"{path}: cannot be read ({error}); check the path") from None
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise UrdfError(f"{path}: it declares entities; write them out")
        if path.suffix == ".xacro" or "<xacro:" in text:
            return expanded(path, packages, arguments)
        if arguments:
            self.refuse(f"it takes no arguments as `{arguments[0]}`", "give a .xacro file")
        self._written = text
        return text
