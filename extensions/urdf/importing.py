"""Writes a robot file from a URDF: reads, guesses what it does not say, and tells both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from shutil import copytree
from tempfile import TemporaryDirectory
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import yaml
from pinocchio import SE3

from config import counted, quoted
from config.reader import ConfigError, read_config
from extensions.urdf.arm_choice import choose_arm, drive_of
from extensions.urdf.hulls import hull_around, placed_points
from extensions.urdf.imported_hand import hand_of
from extensions.urdf.ready import ready_posture
from extensions.urdf.touching_links import Part, postures, touching
from extensions.urdf.urdf_file import MOST_EFFORT, OF_JOINT, Urdf, UrdfError
from robots import (
    GREY,
    SHIPPED,
    Array,
    CameraFile,
    Geom,
    Hull,
    RobotDescription,
    RobotFile,
    load_robot,
)

_LAG = 0.03  # of the joints of a Panda, and of what is no longer [s]
_ACCELERATIONS = (6.0, 1.0)  # the same, of joints that turn and that slide [rad/s^2, m/s^2]
_REACH = 1.1  # from a joint of a Panda to the hand, at most [m]
_LOW = 0.1  # shapes that come down to this height belong to the base [m] ...
_SLENDER = 2.0  # ... unless they are so many times as high as wide: masts, which carry the arm
_ROD = 0.04  # radius of a link without shapes [m]
_SMALL = {"mass": 0.1, "xyz": [0.0] * 3, "moments": [1e-4] * 3, "products": [0.0] * 3}
_ASIDE, _BEHIND = 0.033, 0.015  # of a camera on its own mount, from the palm [m]
_BESIDE = np.array([0.065, 0.0, -0.098])  # a camera on the end effector, at least and usually [m]
_ALONG = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # its axes in those of e
_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""A camera's axes (z ahead, x right) in those of a body (x ahead, z up)."""
_BASES = {"differential": "frankie", "omni": "omni", "none": "frankie"}  # by drive
_STANDING = {"speed": [1e-6, 0.0, 1e-6], "reverse": 1e-6}
_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, kw_only=True)
class ImportOptions:
    """What a person says instead of a guess."""

    srdf: Path | None = None
    base_frame: str | None = None
    tool_frame: str | None = None
    drive: str | None = None  # `differential`, `omni` or `none`
    approach: str | None = None  # axis of the tool frame, for example `x` or `-z`
    closing: str | None = None  # the same
    gripper: str | None = None  # a shipped part to put on the tool frame
    camera_frame: str | None = None
    acceleration: float | None = None  # of joints that turn [rad/s^2]
    base_size: tuple[float, float, float] | None = None  # [m]
    packages: Sequence[Path] = ()
    arguments: Sequence[str] = ()  # of a xacro file, `name:=value`


def write_robot(
    source: Path,
    out: Path,
    options: ImportOptions,
    ready: Callable[[RobotDescription], Array] = ready_posture,
) -> list[str]:
    """Write a folder with a robot file from a URDF; what was read and guessed, a line each.

    `ready` finds the posture of that name. UrdfError: the URDF cannot be used.
    """
    if out.exists():
        raise UrdfError(f"{out}: exists already; choose another folder with -o")
    robot = _Import(Urdf(source, options.packages, options.arguments), options)
    with TemporaryDirectory() as folder:
        draft = Path(folder) / out.resolve().name
        robot.write(draft)
        try:
            drafted = load_robot(draft)
        except ConfigError as error:
            why = str(error).splitlines()[0].partition(": ")[2]  # the draft's place says nothing
            raise UrdfError(f"{source}: {why}") from None
        found = ready(drafted)
        robot.arm_file["ready"] = _rounded(found)
        turned = np.where(robot.slides, found, np.degrees(found))
        robot.notes.append(f"ready: {', '.join(f'{one:.3g}' for one in turned)} (deg, m)")
        robot.write(draft)
        try:
            copytree(draft, out)
        except OSError as error:
            raise UrdfError(f"{out}: cannot be written ({error.strerror})") from None
    return [one.replace(OF_JOINT, "") for one in robot.notes]


class _Import:
    """Makes the contents of the files of one robot.

    u is the root of the URDF, the foot a is the link below the first joint, w the frame of the last
    joint in the URDF. Our own frame of a joint is that of the URDF, turned so that z is the axis.
    """

    def __init__(self, urdf: Urdf, options: ImportOptions) -> None:
        self._options = options
        count = counted(urdf.geometry.ngeoms, "shape")
        self.notes = [f"{urdf.name}: {counted(len(urdf.kinds), 'moving joint')}, {count}"]
        self._arm = arm = choose_arm(
            urdf, options.base_frame, options.tool_frame, options.srdf, self.notes
        )
        other = set(urdf.kinds) - set(arm.joints)
        self.notes += [one for one in urdf.notes if not other & set(one.split("`"))]
        self._hand = hand_of(arm, options.approach, options.closing, self.notes)
        subspaces = [np.ravel(joint.createData().S) for joint in arm.model.joints[1:]]
        self.slides = np.array([np.linalg.norm(S[:3]) > 0.5 for S in subspaces])
        axes = [S[:3] if np.linalg.norm(S[:3]) > 0.5 else S[3:] for S in subspaces]
        turns = [pin.Quaternion.FromTwoVectors(_Z, axis).matrix() for axis in axes]
        self._turns = [SE3(turn, np.zeros(3)) for turn in turns]
        self._uTa = arm.frame(urdf.links[arm.joints[0]][0])[1]
        before = [self._uTa, *self._turns]
        placed = zip(before[:-1], arm.model.jointPlacements[1:], self._turns, strict=True)
        self._joints = [last.inverse() * here * turn for last, here, turn in placed]
        rTe = self._hand.rTe
        if options.gripper is not None:
            rTe = SE3(rTe.rotation, arm.frame(arm.tool)[1].translation)
        self._lTe = self._turns[-1].inverse() * rTe
        self._eTc = self._camera(rTe)
        base, mount = self._base()
        shapes = self._shapes(base, mount)
        self.arm_file = self._arm_of(shapes, base, mount)
        robot = {"base": base, "arm": "arm", "arm_mount": _pose(mount)}
        robot |= {"gripper": options.gripper or "gripper", "camera": "d435"}
        self._robot = robot | {"camera_mount": _pose(self._eTc)}

    def write(self, folder: Path) -> None:
        """Write the files."""
        contents = {f"{folder.name}.yaml": self._robot, "parts/arm.yaml": self.arm_file}
        if self._options.gripper is None:
            contents["parts/gripper.yaml"] = self._gripper()
        (folder / "parts").mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)
            told = f"# Imported from {self._arm.urdf.path.name}. Lengths in m, angles in rad.\n"
            (folder / name).write_text(told + text, encoding="utf-8")

    def _base(self) -> tuple[dict[str, Any], SE3]:
        """The base that wheels or options tell, and the foot on it."""
        arm, options = self._arm, self._options
        guess, why = drive_of(arm)
        drive = options.drive or guess or "differential"
        shipped = _BASES[drive]
        if options.drive is None:
            self.notes.append(f"drive: {drive}, {why} (--drive)")
        file = read_config(SHIPPED / f"{shipped}.yaml", RobotFile, context=(SHIPPED, SHIPPED))
        base = file.base.model_dump(mode="json", exclude_none=True, exclude={"visual"})
        self.notes.append(f"base: speeds and accelerations of `{shipped}`; edit its file")
        if drive == "none":
            base["limits"] |= _STANDING
        self._rides = bool(guess) or arm.base == "base_footprint"
        if not self._rides:
            self.notes.append(f"base: none in the URDF, so that of `{shipped}` (--base-size)")
            mount = file.arm_mount.pose()
            self._bTu = mount * self._uTa.inverse()
        else:
            bTu = arm.frame(arm.base)[1].inverse()
            heights = [float(points[:, 2].min()) for points in self._still(bTu)]
            lift = SE3(np.eye(3), np.array([0.0, 0.0, -min([0.0, *heights])]))
            self._bTu = lift * bTu
            mount = self._bTu * self._uTa
            low = [points for points in self._still(self._bTu) if _is_low(points)]
            if low:
                points = np.vstack(low)
                sides = 2.0 * np.abs(points[:, :2]).max(axis=0)
                base["size"] = _rounded(np.array([*sides, points[:, 2].max()]), 3)
            mass = float(arm.model.inertias[0].mass)
            base["mass"] = round(mass, 3) if mass > 1.0 else base["mass"]
            size = " x ".join(f"{one:g}" for one in base["size"])
            self.notes.append(f"base: {size} m, around its low shapes (--base-size)")
        base["size"] = list(options.base_size or base["size"])
        return base, mount

    def _still(self, bTu: SE3) -> list[Array]:
        """Points of each shape that no joint of the arm moves, in the base."""
        objects = [one for one in self._arm.geometry.geometryObjects if one.parentJoint == 0]
        return [placed_points(one.geometry, bTu * one.placement) for one in objects]

    def _shapes(self, base: dict[str, Any], mount: SE3) -> list[list[Geom]]:
        """Hulls of the foot, in a, and of the links."""
        arm, last = self._arm, len(self._joints)
        ours = set(arm.beyond) if self._options.gripper is None else set()
        shapes: list[list[Geom]] = [[] for _ in range(last + 1)]
        for one in arm.geometry.geometryObjects:
            joint = one.parentJoint
            if joint == last and arm.link_of(one) in ours:
                continue
            aTu = (self._turns[joint - 1] if joint else self._uTa).inverse()
            points = placed_points(one.geometry, self._bTu * one.placement)
            if joint or not self._rides or not _is_low(points):
                points = placed_points(one.geometry, aTu * one.placement)
                shapes[joint] += [hull_around(points)] if len(points) else []
        for number, some in enumerate(shapes[1:last], start=1):
            end = self._joints[number].translation
            if not some and (length := float(np.linalg.norm(end))) > _ROD:
                turn = pin.Quaternion.FromTwoVectors(_Z, end).matrix()
                rod = placed_points(coal.Capsule(_ROD, length), SE3(turn, end / 2.0))
                some.append(hull_around(rod))
                self.notes.append(f"link{number}: no shape, so a rod of {2.0 * _ROD:g} m")
        return shapes

    def _arm_of(self, shapes: list[list[Geom]], base: dict[str, Any], mount: SE3) -> dict[str, Any]:
        arm, joints, middle, model = self._arm, [], [], self._arm.model
        bodies = [
            turn.actInv(one) for turn, one in zip(self._turns, model.inertias[1:], strict=True)
        ]
        solid = all(one.mass > 1e-4 and np.linalg.eigvalsh(one.inertia)[0] > 1e-9 for one in bodies)
        accelerations, torques, lag = self._swiftness(solid)
        columns = arm.joints, self._joints, self.slides, model.joints[1:], accelerations, torques
        for name, pose, slides, joint, acceleration, torque in zip(*columns, strict=True):
            ends = (model.lowerPositionLimit, model.upperPositionLimit)
            between = [round(float(end[joint.idx_q]), 6) for end in ends]
            kind = "prismatic" if slides else "revolute" if joint.nq == 1 else "continuous"
            row = {"name": name.removesuffix(OF_JOINT)} | _pose(pose) | {"kind": kind}
            row |= {"position": between} if joint.nq == 1 else {}
            row["speed"] = round(float(model.velocityLimit[joint.idx_v]), 6)
            joints.append(row | {"acceleration": acceleration, "torque": torque})
            middle.append(sum(between) / 2.0 if joint.nq == 1 else 0.0)
        file = {"joints": joints, "flange": _pose(self._lTe), "ready": middle, "lag": lag}
        links = [arm.urdf.links[one] for one in arm.joints]
        frames = [SE3.Identity(), *(turn.inverse() for turn in self._turns)]
        names = [links[0][0], *(child for _, child in links)]
        file["links"] = [{"name": a} | _pose(b) for a, b in zip(names, frames, strict=True)]
        file["collision"] = []
        file["hulls"] = [{"link": k} | _hull(one) for k, some in enumerate(shapes) for one in some]
        places = [mount * self._joints[0], *self._joints[1:]]
        parts = self._parts(shapes, base, mount)
        file["may_touch"] = touching(arm, parts, places, self.slides, self.notes)
        if solid:
            file["inertia"] = [_SMALL, *map(_inertia, bodies)]
        else:
            self.notes.append("inertia: not of every link, so no physical world")
        return file

    def _swiftness(self, solid: bool) -> tuple[list[float], list[float], float]:
        """Accelerations of the joints, torques, and lag: as of a Panda, less the farther the hand.

        Where all links have inertias (`solid`), a motor accelerates as it can besides holding its
        load; one whose torque is not given is as strong as it needs to be.
        """
        arm, model = self._arm, self._arm.model
        links = [float(np.linalg.norm(one.translation)) for one in (*self._joints[1:], self._lTe)]
        away = np.cumsum(links[::-1])[::-1]  # of the hand from each joint, at most
        share = np.minimum(1.0, _REACH / np.maximum(away, _ROD))
        most = np.where(self.slides, _ACCELERATIONS[1], share * _ACCELERATIONS[0])
        torque, told = model.effortLimit, f"by its reach of {away[0]:.2g} m"
        if solid:
            data, origin = model.createData(), pin.neutral(model)
            drawn = [pin.integrate(model, origin, q) for q in postures(arm)[::10]]
            weights = [np.abs(pin.computeGeneralizedGravity(model, data, q)) for q in drawn]
            weight = np.max(weights, axis=0)
            body = np.max([np.diag(pin.crba(model, data, q)) for q in drawn], axis=0)
            given = np.isin(arm.joints, [*arm.urdf.strong])
            torque = np.where(
                given, torque, np.clip(weight + 2.0 * body * most, torque, MOST_EFFORT)
            )
            spare = (torque - weight) / body
            weak = given & (spare > 0.0) & (spare < most)
            most = np.where(weak, spare, most)
            names = [name for name, one in zip(arm.joints, weak, strict=True) if one]
            told += f" and the torques of {quoted(names)}" if names else ""
        if self._options.acceleration is not None:
            most = np.where(self.slides, most, self._options.acceleration)
        lag = round(_LAG * float(max(1.0, away[0] / _REACH)), 3)
        figures = [float(f"{one:.3g}") for one in most]
        between = " to ".join(f"{one:g}" for one in sorted({min(figures), max(figures)}))
        told = f"{between} rad/s^2 (--acceleration), lag: {lag:g} s, {told}"
        self.notes.append(f"accelerations: {told}")
        return figures, _rounded(torque), lag

    def _parts(self, shapes: list[list[Geom]], base: dict[str, Any], mount: SE3) -> list[Part]:
        """Shapes by part, for the search of those that can touch."""
        frames, ours, last = self._arm.model.frames, set(self._arm.beyond), len(self._joints)
        parts = [Part("base", 0, tuple(base["size"]), {self._arm.base})]
        for joint, some in enumerate(shapes):
            links = {str(frame.name) for frame in frames if frame.parentJoint == joint}
            placed = some if joint else [one.moved(mount) for one in some]
            parts.append(Part(f"link{joint}", joint, placed, links - ours))
        hand = [one.moved(self._lTe) for one in self._hand.collision]
        body = read_config(SHIPPED / "parts" / "d435.yaml", CameraFile).body.geom("", GREY)
        camera = [body.moved(self._lTe * self._eTc)]
        parts += [Part("hand", last, hand, ours), Part("camera", last, camera, set())]
        return [*parts, Part("floor", 0, None, set())]

    def _camera(self, rTe: SE3) -> SE3:
        """The camera on the end effector: at its frame, or beside the hand."""
        arm, link = self._arm, self._options.camera_frame
        hand, last = self._hand, len(self._joints)
        named = [one for one in arm.urdf.parents if "camera" in one]
        named = [one for one in named if "optical" in one] or named
        held = [one for one in ([link] if link else named) if one in arm.urdf.parents]
        held = [one for one in held if arm.frame(one)[0] == last]
        if link and not held:
            what = f"camera on `{link}`: not on the hand, and no other place is supported"
            arm.urdf.refuse(what, "leave out --camera-frame for a D435 beside the hand")
        if held:
            self.notes.append(f"camera: at `{held[0]}` (--camera-frame)")
            turn = np.eye(3) if "optical" in held[0] else _OPTICAL
            return rTe.inverse() * arm.frame(held[0])[1] * SE3(turn, np.zeros(3))
        place = _BESIDE
        if self._options.gripper is None:
            centre, size = hand.palm
            aside, behind = centre[0] + size[0] / 2.0 + _ASIDE, centre[2] - _BEHIND
            place = np.array([max(_BESIDE[0], aside), 0.0, min(-0.06, behind)])
        where = f"{place[0]:.3f} m beside and {-place[2]:.3f} m behind the grasp centre"
        none = f"camera on `{named[0]}`: not" if named else "camera: none"
        self.notes.append(f"{none} on the hand; a D435 is assumed {where} (--camera-frame)")
        return SE3(_ALONG, place)

    def _gripper(self) -> dict[str, Any]:
        hand = self._hand
        centre, radius = hand.ball
        boxes = {"palm": hand.palm, "finger": hand.finger, "pad": hand.pad}
        file: dict[str, Any] = {"grasp_centre": {"xyz": [0.0] * 3}}
        file |= {"opening": round(hand.opening, 5), "speed": round(hand.speed, 4)}
        file |= {k: {"xyz": _rounded(c), "size": _rounded(s)} for k, (c, s) in boxes.items()}
        file["pad"]["xyz"][1] = file["pad"]["size"][1] / 2.0
        file["ball"] = {"xyz": _rounded(centre), "radius": round(radius, 5)}
        file["collision"] = []
        file["hulls"] = [_hull(one) for one in hand.collision]
        return file | {"inertia": _SMALL, "finger_mass": 0.03, "grasps": hand.grasps}


def _is_low(points: Array) -> bool:
    """Whether a shape belongs to the base: it comes down to the floor, and is no mast."""
    wide = np.ptp(points[:, :2], axis=0).max(initial=0.0)
    return bool(points[:, 2].min() < _LOW and np.ptp(points[:, 2]) < _SLENDER * wide)


def _rounded(values: Array, digits: int = 6) -> list[float]:
    return [round(float(one), digits) + 0.0 for one in values]


def _pose(pose: SE3) -> dict[str, Any]:
    rows = [_rounded(row, 12) for row in pose.rotation]
    turned = {} if np.allclose(pose.rotation, np.eye(3), atol=1e-9) else {"rotation": rows}
    return {"xyz": _rounded(pose.translation), **turned}


def _hull(one: Geom) -> dict[str, Any]:
    assert isinstance(one.shape, Hull)
    return {"corners": [_rounded(p) for p in one.shape.vertices + one.pose.translation]}


def _inertia(one: pin.Inertia) -> dict[str, Any]:
    file = {"mass": round(float(one.mass), 6), "xyz": _rounded(one.lever)}
    file["moments"] = _rounded(np.diag(one.inertia), 12)
    return file | {"products": _rounded(one.inertia[[0, 0, 1], [1, 2, 2]], 12)}
