"""The hand of an imported arm: end effector, and a parallel gripper from its finger joints."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config import quoted
from extensions.urdf.arm_choice import Arm, positions
from extensions.urdf.hulls import hull_around, placed_points
from robots import CORNERS, Array, Geom

_TIP = 0.02  # length of the pads along the approach [m]
_OPENINGS = (0.005, 0.4)  # smallest and largest opening of a gripper [m]
_WIDEST = 0.12  # opening of a gripper that is used: more is in the way beside an object [m]
_PADS = (0.004, 0.01)  # least and most thickness of a pad [m]
_POSTURES = 41  # of a jaw that closes on a fixed one, in its range
_MIDDLE = 0.25  # share of the opening on both sides of its middle that belongs to what is held
_FEW = 200  # points of a shape that is too coarse to be cut
_THIN, _STUB = 0.002, 0.02  # half sizes of a finger of a tool, and of a tool without shapes [m]
_FASTEST, _SLOW = 0.2, 0.1  # speeds of a gripper: most that is believed, and without slides [m/s]
_WORLD = np.eye(3)

BoxFit: TypeAlias = tuple[Array, Array]  # centre and edge lengths (3,) each
_Fingers: TypeAlias = dict[str, Array]  # points (N, 3) by the first joint of each


@dataclass
class Hand:
    """What is beyond the last link, and on what: the frame of the last joint as in the URDF."""

    rTe: SE3  # end effector, z along the approach and y the closing direction
    opening: float
    speed: float
    palm: BoxFit  # in e
    finger: BoxFit  # the left one, when the pads touch
    pad: BoxFit
    collision: list[Geom]  # in e
    grasps: bool = True

    @property
    def ball(self) -> tuple[Array, float]:
        """Centre in e and radius of a ball around palm and open fingers."""
        wide = np.array([0.0, self.opening / 2.0, 0.0])
        boxes = (self.palm, self.finger, self.pad)
        points = np.vstack([centre + CORNERS * size / 2.0 for centre, size in boxes])
        points = np.vstack([points, points + wide, points * [1.0, -1.0, 1.0] - wide])
        middle = (points[:, 2].min() + points[:, 2].max()) / 2.0
        centre = np.array([0.0, 0.0, middle])
        return centre, float(np.linalg.norm(points - centre, axis=1).max()) + 1e-3


class _Jaws(NamedTuple):
    """Two fingers that close on each other; points (N, 3) are in the wrist."""

    opening: float
    middle: Array  # (3,) between their tips, in the axes of e
    sides: list[Array]  # points of the left ones and of the right ones, open
    fingers: list[Array]  # points of each that moves, open and closed
    palm: Array  # points of what stands still
    names: list[list[str]]  # of the fingers on the left and on the right
    wide: int  # of the two ends of their range the open one
    speed: float = 0.0  # if one moves and the other does not
    told: str = ""


def hand_of(arm: Arm, approach: str | None, closing: str | None, notes: list[str]) -> Hand:
    """The hand as its shapes and finger joints tell; without fingers a tool that grasps nothing."""
    rTt = arm.frame(arm.tool)[1]
    still, ends = _points(arm, 2)
    everything = np.vstack([still, *ends[0].values(), *ends[1].values()])
    towards = everything.mean(axis=0) if len(everything) else rTt.translation
    axes = {name: rTt.rotation[:, k] for k, name in enumerate("xyz")}
    axes |= {f"-{name}": -axis for name, axis in axes.items()}
    if approach is None:
        approach = max(axes, key=lambda name: float(axes[name] @ towards) + 1e-6 * (name == "z"))
        notes.append(f"approach: {approach} of `{arm.tool}`, where the hand is (--approach)")
    z = axes[approach]
    moved = [ends[1][name].mean(axis=0) - ends[0][name].mean(axis=0) for name in ends[0]]
    across = [axes[name] for name in "yx" if abs(axes[name] @ z) < 0.5]
    tried = [axes[closing]] if closing else [*sorted(moved, key=lambda v: -float(v @ v)), *across]
    flat = (one - (one @ z) * z for one in (*tried, *_WORLD))
    y = next(one / np.linalg.norm(one) for one in flat if np.linalg.norm(one) > 1e-3)
    R = np.column_stack([np.cross(y, z), y, z])
    jaws = _on_fixed_jaw(arm, R) if len(moved) == 1 else _two_jaws(arm, still, ends, R)
    if jaws is None:
        why = _why_none(arm, list(ends[0]))
        notes.append(f"gripper: {why}, so no grasps without --gripper franka_hand")
        return _tool(SE3(R, rTt.translation), everything)
    slides = [2.0 * _speed(arm, one) for one in arm.fingers if arm.urdf.kinds[one] == "prismatic"]
    told = f"{len(moved)} moving parts, taken as two jaws, " if len(moved) > 2 else jaws.told
    notes.append(f"gripper: {told}opens by {jaws.opening:.3f} m (--closing, --gripper)")
    rTe = SE3(R, R @ jaws.middle)
    left, right = ((one - rTe.translation) @ R for one in jaws.sides)
    right *= [1.0, -1.0, 1.0]
    finger = np.vstack([one - [0.0, _tip(one)[:, 1].min(), 0.0] for one in (left, right)])
    centre, size = _box(np.maximum(finger, [-np.inf, 0.0, -np.inf]))
    thick = float(np.clip(0.5 * size[1], *_PADS))
    palm, *bodies = ((one - rTe.translation) @ R for one in (jaws.palm, still, *jaws.fingers))
    return Hand(
        rTe=rTe,
        opening=jaws.opening,
        speed=min([_FASTEST, *([jaws.speed] if jaws.speed else slides or [_SLOW])]),
        palm=_box(palm) if len(palm) else _box(_STUB * CORNERS - [0.0, 0.0, 4.0 * _STUB]),
        finger=(centre, size),
        pad=(
            np.array([centre[0], thick / 2.0, 0.0]),
            np.array([min(float(size[0]), _TIP), thick, _TIP]),
        ),
        collision=[hull_around(one) for one in bodies if len(one)],
    )


def _why_none(arm: Arm, shaped: list[str]) -> str:
    """Why it has no gripper; `shaped` are the joints of its fingers that have shapes."""
    above = {one: set(arm.urdf.path_to(arm.urdf.links[one][0])) for one in arm.fingers}
    bare = [one for one in arm.fingers if not above[one] & set(arm.fingers) and one not in shaped]
    if sucks := [one for one in arm.beyond if re.search(r"suction|vacuum", one, re.IGNORECASE)]:
        return f"no fingers: suction, as of `{sucks[0]}`, is not supported"
    if not arm.fingers:
        return "none in the URDF"
    if bare:
        return f"no collision shapes on what moves by {quoted(bare[:4])}"
    if len(shaped) == 1:
        return f"one jaw (`{shaped[0]}`), and nothing fixed that it closes on"
    low, high = (1e3 * one for one in _OPENINGS)
    return f"{len(shaped)} moving parts, none closes on another by {low:.0f} to {high:.0f} mm"


def _points(arm: Arm, count: int) -> tuple[Array, list[_Fingers]]:
    """In the wrist: points (N, 3) that stand still, and the fingers at places of their range."""
    urdf, model = arm.urdf, arm.urdf.model
    wrist, beyond = model.getJointId(arm.joints[-1]), set(arm.beyond)
    still, found = [np.zeros((0, 3))], list[_Fingers]()
    for share in np.linspace(0.0, 1.0, count):
        leaders = [one for one in arm.fingers if one not in urdf.mimics]
        told = {one: _place(arm, one, share) for one in leaders}
        data, geometry = model.createData(), pin.GeometryData(urdf.geometry)
        q = positions(urdf, {name: one for name, one in told.items() if abs(one) < 2.0 * np.pi})
        pin.updateGeometryPlacements(model, data, urdf.geometry, geometry, q)
        fingers: dict[str, list[Array]] = {}
        for number, one in enumerate(urdf.geometry.geometryObjects):
            link = str(model.frames[one.parentFrame].name)
            if link not in beyond:
                continue
            rTs = data.oMi[wrist].actInv(geometry.oMg[number])
            points = placed_points(one.geometry, rTs)
            while 1 < len(points) < _FEW:  # a box has none but its corners
                pairs = np.triu_indices(len(points), 1)
                points = np.vstack([points, (points[pairs[0]] + points[pairs[1]]) / 2.0])
            moving = [joint for joint in urdf.path_to(link) if joint in arm.fingers]
            if moving:
                fingers.setdefault(moving[0], []).append(points)
            elif not found:
                still.append(points)
        found.append({name: np.vstack(some) for name, some in fingers.items()})
    return np.vstack(still), found


def _place(arm: Arm, joint: str, share: float) -> float:
    """The position of a joint at a share of its range [rad, or m]."""
    row, model = arm.urdf.joint(joint).idx_q, arm.urdf.model
    low, high = model.lowerPositionLimit[row], model.upperPositionLimit[row]
    return float(low + share * (high - low))


def _speed(arm: Arm, joint: str) -> float:
    return float(arm.urdf.model.velocityLimit[arm.urdf.joint(joint).idx_v])


def _on_fixed_jaw(arm: Arm, R: Array) -> _Jaws | None:
    """One moving jaw and what stands still, where their tips are level; None if they never are.

    They open to the width between these tips; the palm ends where it is free between them.
    """
    still, places = _points(arm, _POSTURES)
    (joint,) = places[0]
    if not len(still):
        return None
    apart, gaps = [], []
    for place in places:
        fixed, moving = still @ R, place[joint] @ R
        ends = fixed[:, 2].max(), moving[:, 2].max()
        apart.append(abs(ends[1] - ends[0]))
        a, b = (one[one[:, 2] > min(ends) - _TIP, 1] for one in (fixed, moving))
        gaps.append(max(b.min() - a.max(), a.min() - b.max()))
    level = [k for k, one in enumerate(apart) if one < _TIP]
    if not level:
        return None
    order = sorted(level, key=lambda k: gaps[k])
    shut, wide = order[0], order[-1]
    jaws = _jaws(still, [{"": still} | places[k] for k in (shut, wide)], R)
    if jaws is None:
        return None
    both = np.vstack(jaws.sides) @ R - jaws.middle
    between = (np.abs(both[:, :2]) < [_TIP, _MIDDLE * jaws.opening]).all(axis=1)
    tips = [float((one @ R[:, 2]).max()) for one in jaws.sides]
    height = min(jaws.middle[2] + both[between, 2].max(initial=-1.0), min(tips) - _TIP)
    q_shut, q_wide = (_place(arm, joint, k / (_POSTURES - 1.0)) for k in (shut, wide))
    return jaws._replace(
        sides=[one[one @ R[:, 2] > height] for one in jaws.sides],
        fingers=[np.vstack([places[k][joint] for k in (shut, wide)])],
        palm=still[still @ R[:, 2] <= height],
        speed=jaws.opening * _speed(arm, joint) / abs(q_wide - q_shut),
        told=f"jaw `{joint}` closes on a fixed one, from {q_wide:.3g} to {q_shut:.3g}, ",
    )


def _two_jaws(arm: Arm, still: Array, ends: list[_Fingers], R: Array) -> _Jaws | None:
    """The two sides of a gripper, from where they meet to where their tips are level still."""
    full = _jaws(still, ends, R)
    if full is None:
        return None
    places = _points(arm, _POSTURES)[1][:: 1 if full.wide else -1]
    gaps = [_gap(*_tips(place, full.names, R)) for place in places]
    meet = max((k for k, gap in enumerate(gaps) if gap <= 0.0), default=0)
    shut = places[meet]
    level = max(float((points @ R[:, 2]).max()) for points in shut.values()) - 1.5 * _TIP
    some = [_jaws(still, [shut, place], R) for place in places[meet + 1 :]]
    fits = [one for one in some if one and one.middle[2] > level and one.opening < _WIDEST]
    used = max(fits, key=lambda one: one.opening, default=full)
    if full.opening - used.opening < _TIP:
        return full
    return used._replace(told=f"with level tips, of {full.opening:.3f} m, ")


def _jaws(still: Array, ends: list[_Fingers], R: Array) -> _Jaws | None:
    """The two sides of a gripper with axes R in the wrist; None if they do not close."""
    at = {name: np.mean([(end[name] @ R)[:, 1].mean() for end in ends]) for name in ends[0]}
    middle = (min(at.values()) + max(at.values())) / 2.0 if at else 0.0
    sides = [[name for name in at if (at[name] > middle) == left] for left in (True, False)]
    if not all(sides):
        return None
    gaps, tips = [], []
    for end in ends:
        left, right = _tips(end, sides, R)
        gaps.append(_gap(left, right))
        between = (left[:, 1].min() + right[:, 1].max()) / 2.0
        both = np.vstack([left, right])
        x = (both[:, 0].min() + both[:, 0].max()) / 2.0
        tips.append(np.array([x, between, both[:, 2].max() - _TIP / 2.0]))
    wide = int(gaps[1] > gaps[0])
    opening = gaps[wide] - max(0.0, gaps[1 - wide])  # its pads may not touch when it is closed
    if not _OPENINGS[0] < opening < _OPENINGS[1]:
        return None
    open_ = [np.vstack([ends[wide][name] for name in side]) for side in sides]
    fingers = [np.vstack([end[name] for end in ends]) for name in at]
    return _Jaws(opening, tips[wide], open_, fingers, still, sides, wide)


def _tool(rTe: SE3, points: Array) -> Hand:
    """A tool that grasps nothing: all its shapes are its palm."""
    shown = (points - rTe.translation) @ rTe.rotation
    shown = shown if len(shown) else _STUB * CORNERS - [0.0, 0.0, _STUB]
    finger = np.array([0.0, _THIN, -_THIN]), np.full(3, 2.0 * _THIN)
    around = [hull_around(shown)]
    return Hand(rTe, _THIN, _SLOW, _box(shown), finger, finger, around, grasps=False)


def _tips(end: _Fingers, sides: list[list[str]], R: Array) -> tuple[Array, Array]:
    """The ends of the fingers of both sides, in axes R."""
    left, right = (_tip(np.vstack([end[name] for name in side]) @ R) for side in sides)
    return left, right


def _gap(left: Array, right: Array) -> float:
    """The distance between two tips; negative if they have crossed."""
    return float(left[:, 1].min() - right[:, 1].max())


def _tip(points: Array) -> Array:
    tip: Array = points[points[:, 2] > points[:, 2].max() - _TIP]
    return tip


def _box(points: Array) -> BoxFit:
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2.0, np.maximum(high - low, 2.0 * _THIN)
