"""Chooses the arm of a URDF: its base frame, tool frame and joints; locks all other joints."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config import quoted, suggest
from extensions.urdf.urdf_file import Urdf, UrdfError
from robots import MOST_JOINTS, Array

_BASES = ("base_footprint", "base_link", "chassis", "base")
_TOOLS = (
    r"(^|_)(tcp|grasp\w*|tool_cent(er|re)\w*)(_link|_frame)?$",
    r"(^|_)tool0?(_link|_frame)?$",
    r"(^|_)(ee|eef|end_?effector)\w*$",
    r"(^|_)(hand|gripper|palm)(_base|_palm)?(_link|_frame)?$",
    r"(^|_)(flange|link_?[678])$",
    "",
)
"""Names of links that are tool frames, the likely ones first; the last fits all."""
_HANDS = re.compile("|".join(_TOOLS[:4]), re.IGNORECASE)
_FLIES = re.compile(r"propeller|(^|_)rotor_?\d|copter|drone|flying|uav", re.IGNORECASE)
_FINGER = re.compile(r"finger|gripper|jaw|knuckle|thumb|hand_", re.IGNORECASE)
_WHEEL = re.compile(r"wheel", re.IGNORECASE)
_LOOSE = re.compile(r"caster|roller", re.IGNORECASE)
_HOLONOMIC = re.compile(r"mecanum|omni|swedish|roller", re.IGNORECASE)
_SHORTER = 2  # joints by which a named tool frame may be nearer than the farthest link
_LARGEST = 10.0  # a robot is smaller than this [m]
_TURNS = 8.0 * np.pi  # no joint of an arm turns farther between its ends [rad]


@dataclass
class Arm:
    """The arm in a URDF, whose other joints are locked."""

    urdf: Urdf
    base: str  # link
    tool: str  # link
    joints: list[str]
    model: pin.Model  # of these joints
    geometry: pin.GeometryModel
    fingers: list[str]  # joints beyond the last of the arm
    disabled: set[frozenset[str]]  # pairs of links that the SRDF lets touch

    @property
    def beyond(self) -> list[str]:
        """The links of the hand: those after the one that the last joint moves.

        That one is of the hand, too, if a single jaw hangs on it: it has the other.
        """
        urdf, last = self.urdf, self.urdf.links[self.joints[-1]][1]
        has_jaw = [urdf.links[one][0] for one in self.fingers] == [last]
        paths = {link: urdf.path_to(link) for link in urdf.parents}
        hand = [link for link, path in paths.items() if self.joints[-1] in path[:-1]]
        return [last] * has_jaw + hand

    def frame(self, link: str) -> tuple[int, SE3]:
        """The joint that moves a link (0: none), and its pose in that joint's frame."""
        frame = self.model.frames[self.model.getFrameId(link, pin.FrameType.BODY)]
        return frame.parentJoint, frame.placement

    def link_of(self, shape: Any) -> str:
        """The link that a shape of the geometry belongs to."""
        return str(self.model.frames[shape.parentFrame].name)


def choose_arm(
    urdf: Urdf, base: str | None, tool: str | None, srdf: Path | None, notes: list[str]
) -> Arm:
    """The arm between two links, or between those that names tell; UrdfError: there is none."""
    links = [urdf.root, *urdf.parents]
    for one in filter(None, (base, tool)):
        if one not in links:
            urdf.refuse(f"no link is called `{one}`", suggest(one, links))
    semantics = ElementTree.Element("robot") if srdf is None else _srdf(srdf)
    if base is None:
        base = next((name for name in _BASES if name in links), urdf.root)
        if flies := [one for one in (urdf.name, *links) if _FLIES.search(one)]:
            what = f"it flies, as `{flies[0]}` is called, and a base drives"
            urdf.refuse(what, "choose the link below its arm with --base-frame")
        notes.append(f"base frame: `{base}`, by its name (--base-frame)")
    start, fingers = urdf.path_to(base), _finger_joints(urdf)
    chains = {}
    for link in urdf.parents:
        path = urdf.path_to(link)
        moving = [one for one in path[len(start) :] if one in urdf.kinds]
        if path[: len(start)] == start and not fingers & set(moving):
            chains[link] = moving
    if tool is None:
        tool = _tool(urdf, base, chains, fingers, semantics, notes)
    joints = chains.get(tool, [])
    if tied := [one for one in joints if one in urdf.mimics]:
        what = f"joint `{tied[0]}` moves with `{urdf.mimics[tied[0]].of}` (<mimic>) in the arm"
        hint = "remove the <mimic> if it has a motor of its own, or end before it: --tool-frame"
        urdf.refuse(f"{what}, as in a parallelogram, which is not supported", hint)
    if tool not in chains and (held := [one for one in urdf.path_to(tool) if one in fingers]):
        what = f"joint `{held[0]}` before `{tool}` is one of a hand, by its name or place"
        urdf.refuse(what, "choose a link before it with --tool-frame")
    if not 1 <= len(joints) <= MOST_JOINTS:
        what = f"{len(joints)} joints of an arm from `{base}` to `{tool}`, not 1 to {MOST_JOINTS}"
        urdf.refuse(what, "choose links with --base-frame and --tool-frame")
    locked = [one for one in urdf.kinds if one not in joints]
    numbers, q = [urdf.model.getJointId(one) for one in locked], positions(urdf, {})
    try:
        model, geometry = pin.buildReducedModel(urdf.model, urdf.geometry, numbers, q)
    except Exception as error:  # of a library, on a model that anybody may have made
        urdf.refuse(f"its joints cannot be locked ({error})", "check the file with `check_urdf`")
    pairs = semantics.iter("disable_collisions")
    disabled = {frozenset((one.get("link1", ""), one.get("link2", ""))) for one in pairs}
    beyond = [one for one in locked if joints[-1] in urdf.path_to(urdf.links[one][1])]
    arm = Arm(urdf, base, tool, joints, model, geometry, beyond, disabled)
    _check(arm)
    at = joint_values(urdf, {})
    told = [f"{one} at {at[one]:.2g}" for one in locked if not _WHEEL.search(one)]
    if told:
        more = f" and {len(told) - 6} more" if len(told) > 6 else ""
        notes.append(f"locked joints: {', '.join(told[:6])}{more}")
    return arm


def joint_values(urdf: Urdf, told: dict[str, float]) -> dict[str, float]:
    """Positions by joint: as told, else zero within the limits, or as what they mimic."""
    low, high = urdf.model.lowerPositionLimit, urdf.model.upperPositionLimit
    rows = {name: urdf.joint(name).idx_q for name in urdf.kinds}
    values = {name: float(np.clip(0.0, low[k], high[k])) for name, k in rows.items()} | told
    for name, mimic in urdf.mimics.items():
        values[name] = mimic.multiplier * values.get(mimic.of, 0.0) + mimic.offset
    return values


def positions(urdf: Urdf, told: dict[str, float]) -> Array:
    """Positions of all joints, as those of `joint_values`."""
    q = pin.neutral(urdf.model)
    for name, value in joint_values(urdf, told).items():
        joint = urdf.joint(name)
        unit = value if joint.nq == 1 else (np.cos(value), np.sin(value))
        q[joint.idx_q : joint.idx_q + joint.nq] = unit
    return np.asarray(q)


def drive_of(arm: Arm) -> tuple[str, str]:
    """The drive that its wheels tell, empty if it has none, and why."""
    urdf = arm.urdf
    driven = [one for one in urdf.kinds if _WHEEL.search(one) and not _LOOSE.search(one)]
    if not driven:
        return "", "assumed as the file has no wheels"
    words = " ".join([urdf.name, *urdf.kinds, *urdf.parents])
    is_holonomic = _HOLONOMIC.search(words) is not None or len(driven) == 3
    return "omni" if is_holonomic else "differential", f"by its {len(driven)} wheels"


def _check(arm: Arm) -> None:
    urdf = arm.urdf
    for name in arm.joints:
        joint = urdf.joint(name)
        ends = urdf.model.lowerPositionLimit, urdf.model.upperPositionLimit
        stroke = ends[1][joint.idx_q] - ends[0][joint.idx_q]
        if urdf.kinds[name] == "prismatic" and not 0.0 < stroke < _LARGEST:
            what = f"joint `{name}` slides and has no range" if stroke <= 0.0 else ""
            what = what or f"joint `{name}` slides by {stroke:g} m"
            urdf.refuse(what, "give it a <limit>, or choose a link above it with --base-frame")
        if urdf.kinds[name] == "revolute" and stroke > _TURNS:
            what = f"joint `{name}` turns by {stroke:g} rad, which looks like degrees"
            urdf.refuse(what, "write its <limit> in radians, or make it continuous")
    apart = max(float(np.linalg.norm(one.translation)) for one in arm.model.jointPlacements)
    if apart > _LARGEST:
        what = f"two joints are {apart:.0f} m apart"
        urdf.refuse(what, "if its lengths are millimetres, write them in metres")
    for one in arm.geometry.geometryObjects:
        one.geometry.computeLocalAABB()
        size = 2.0 * float(one.geometry.aabb_radius)
        away = float(np.linalg.norm(one.placement.translation))
        if not max(size, away) < _LARGEST:
            what = f"a shape of `{arm.link_of(one)}` is {max(size, away):.0f} m large or away"
            urdf.refuse(what, 'give a mesh in millimetres scale="0.001 0.001 0.001"')


def _finger_joints(urdf: Urdf) -> set[str]:
    """Joints of hands: they mimic, are mimicked, are called so, or hang side by side at the end.

    A joint that mimics another is one of an arm if either carries a joint that moves on its own, or
    if both follow each other in a row that has none beside it.
    """
    found = {name for name in urdf.kinds if _FINGER.search(name)}
    tied = set(urdf.mimics) | {one.of for one in urdf.mimics.values()}
    below: dict[str, list[str]] = {name: [] for name in (*urdf.kinds, "")}
    carry = set[str]()
    for name in urdf.kinds:
        above = [one for one in urdf.path_to(urdf.links[name][0]) if one in urdf.kinds]
        below[(above or [""])[-1]].append(name)
        carry |= set() if name in tied | found else set(above)
    rows = [some[0] for some in below.values() if len(some) == 1]
    for name, mimic in urdf.mimics.items():
        is_row = {name, mimic.of} <= set(rows) and mimic.of in urdf.path_to(urdf.links[name][1])
        found |= {name, mimic.of} if not is_row and not {name, mimic.of} & carry else set()
    for some in [some for above, some in below.items() if above]:
        ends = {name for name in some if not below[name]}
        found |= ends if len(ends) > 1 else set()
    return found


def _tool(
    urdf: Urdf,
    base: str,
    chains: dict[str, list[str]],
    fingers: set[str],
    semantics: Any,
    notes: list[str],
) -> str:
    """The tool frame that the SRDF or names tell, on the longest arm."""
    most = max(map(len, chains.values()), default=0)
    if not most:
        urdf.refuse(f"no arm is on `{base}`", "choose another link with --base-frame")
    tips, pattern = [str(one.get("tip_link")) for one in semantics.iter("chain")], ""
    named = [link for link in tips if link in chains]
    for pattern in () if named else _TOOLS:
        named = [
            link
            for link, joints in chains.items()
            if re.search(pattern, link, re.IGNORECASE) and len(joints) >= max(1, most - _SHORTER)
        ]
        if named:
            break
    best = max(named, key=lambda link: (len(chains[link]), "right" in link, -len(link)))
    equal = {tuple(some): link for link, some in chains.items() if len(some) == len(chains[best])}
    hands = [set(urdf.path_to(one)) for one in urdf.parents if _HANDS.search(one)]
    hands += [set(urdf.path_to(urdf.links[one][1])) for one in fingers]
    if not tips and len(equal) > 1 and not any(set(some) <= one for some in equal for one in hands):
        what = f"{len(equal)} equal chains on `{base}`, to {quoted([*equal.values()][:4])}"
        hint = "choose the end of the arm with --tool-frame"
        urdf.refuse(f"{what}, and no hand or tool: legs and fingers are no arms", hint)
    why = "the SRDF" if tips else "its name" if pattern else "the longest chain"
    notes.append(f"tool frame: `{best}`, by {why} (--tool-frame)")
    other = [one for one in named if len(chains[one]) == len(chains[best])]
    if other := [one for one in other if chains[one] != chains[best]]:
        notes.append(f"another arm ends at {quoted(other[:3])}: its joints are locked")
    return best


def _srdf(path: Path) -> Any:
    try:
        return ElementTree.fromstring(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ElementTree.ParseError) as error:
        raise UrdfError(f"{path}: no SRDF ({error}); check --srdf") from None
