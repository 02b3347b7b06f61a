"""Contacts of a closing gripper with an object: held, or why not.

There are no dynamics. The fingers close until a pad touches an object; that object slides along the
closing axis until both pads press on it; while the pads cannot hold it there they turn it, always
towards a smaller width. It is held when two contact points see each other from within both friction
cones (antipodal grasp: Nguyen, "Constructing force-closure grasps", 1988), and friction carries its
weight.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

import numpy as np
from pinocchio import SE3, exp3

from hw.sim.contact import patch, separation, travel
from hw.sim.hand import SIDES, Hand
from hw.sim.sim_object import SimObject
from robots import Array, Geom

GRAVITY = 9.81
"""[m/s²]."""

MAX_DRAG = 0.025
"""Farthest that a single pad drags an object before it rolls or tips away [m]."""

_MARGIN = 0.003
"""Contacts are searched from this far outside of the pads' first positions [m]."""

_PRESS = 5e-4
"""Depth by which the pads yield when they press [m]."""

_TURN_STEP = np.deg2rad(3.0)
_MAX_TURNS = 15
_SINKS = 1e-6
_DOWN = np.array([0.0, 0.0, -1.0])
_MIN_GAIN = 2e-5
_MIN_OVERLAP = 0.001
_BLOCK = 0.001
_NEIGHBOUR_MARGIN = 5e-4

Contact: TypeAlias = tuple[Array, Array]


class Reason(Enum):
    """How closing the fingers ended; the values are for people."""

    HELD = "held"
    NOTHING = "nothing between the fingers"
    TWO_OBJECTS = "two objects between the fingers"
    ONE_PAD = "only one pad touches"
    TOO_WIDE = "too wide for the fingers"
    NOT_ANTIPODAL = "the pads slip off: their faces do not oppose each other"
    BLOCKED = "the push is blocked"
    TIP_CONTACT = "only the very tips touch"
    TOO_HEAVY = "too heavy for the grip"


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspContact:
    """How closing the fingers ended."""

    reason: Reason
    width: float
    """Distance between the pads where they came to rest [m]."""
    object: SimObject | None = None
    """The object that the pads pressed on, if any."""
    wTo: SE3 | None = None
    """Its new pose in the world, if it was moved."""


def grasp_contact(
    hand: Hand,
    opening: float,
    force: float,
    objects: Iterable[SimObject],
    fixtures: Sequence[Geom],
) -> GraspContact:
    """Decide what closing the fingers does.

    Args:
        hand: the gripper and where it is.
        opening: distance between the pads before [m].
        force: of each finger [N].
        objects: near the hand.
        fixtures: near the hand.
    """
    reached = [(o, half) for o in objects if (half := _first_touch(hand, opening, o.placed()))]
    jam = _first_touch(hand, opening, fixtures) or 0.0
    if not reached:
        return GraspContact(reason=Reason.BLOCKED if jam else Reason.NOTHING, width=2.0 * jam)
    reached.sort(key=lambda entry: -entry[1])
    target, touched = reached[0]
    halted = 2.0 * max(touched, jam)

    fit = _fit(hand, opening, target, target.pose)
    if fit is None or fit.drag > MAX_DRAG:
        return GraspContact(reason=Reason.ONE_PAD, width=halted, object=target)
    if fit.width > opening + _PRESS:
        return GraspContact(reason=Reason.TOO_WIDE, width=opening, object=target)
    half = fit.width / 2.0 + _NEIGHBOUR_MARGIN
    if len(reached) > 1 and reached[1][1] > half:
        return GraspContact(reason=Reason.TWO_OBJECTS, width=halted, object=target)
    if jam > half:
        return GraspContact(reason=Reason.BLOCKED, width=halted, object=target)

    slid = fit.wTo
    fit, angle = _turned_flush(hand, opening, target, fit)
    neighbours = [*fixtures, *(p for o in objects if o is not target for p in o.placed())]
    if _pushed_into(target, fit.wTo, neighbours):
        return GraspContact(reason=Reason.BLOCKED, width=halted, object=target)
    if angle > np.arctan(target.friction):
        return GraspContact(reason=Reason.NOT_ANTIPODAL, width=fit.width, object=target, wTo=slid)
    if _overlap(hand, fit) < _MIN_OVERLAP:
        return GraspContact(reason=Reason.TIP_CONTACT, width=fit.width, object=target, wTo=slid)
    if target.mass * GRAVITY > 2.0 * target.friction * force:
        return GraspContact(reason=Reason.TOO_HEAVY, width=fit.width, object=target, wTo=slid)
    return GraspContact(reason=Reason.HELD, width=fit.width, object=target, wTo=fit.wTo)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fit:
    """An object centred between the pads, both touching."""

    wTo: SE3
    width: float
    drag: float
    contacts: tuple[tuple[Contact, ...], tuple[Contact, ...]]
    """On the left and on the right pad: patches, and normals from pad to object."""


def _first_touch(hand: Hand, opening: float, shapes: Sequence[Geom]) -> float | None:
    """Distance of the pads from the centre when the first of them touches any of the shapes."""
    gone = [_closing(hand, side, opening / 2.0, shapes) for side in SIDES]
    touched = [opening / 2.0 - g for g in gone if g is not None]
    return max(touched, default=None)


def _closing(hand: Hand, side: str, start: float, shapes: Sequence[Geom]) -> float | None:
    """How far a pad can close from `start` to the centre before it touches."""
    return travel(hand.pad(side, start), hand.inwards(side), shapes, start)


def _fit(hand: Hand, opening: float, target: SimObject, wTo: SE3) -> _Fit | None:
    """Slide an object along the closing axis until both pads touch; None if one misses it."""
    parts = target.placed(wTo)
    start = opening / 2.0 + _MARGIN
    extent = {}
    for side in SIDES:
        gone = travel(hand.pad(side, start), hand.inwards(side), parts, 2.0 * start)
        if gone is None:
            return None
        extent[side] = start - gone
    width = extent["left"] + extent["right"]
    offset = (extent["left"] - extent["right"]) / 2.0
    slid = SE3(wTo.rotation, wTo.translation - offset * hand.wTe.rotation[:, 1])
    parts = target.placed(slid)
    left, right = (
        [
            found
            for part in parts
            if (found := patch(hand.pad(side, width / 2.0 - _PRESS), part)) is not None
        ]
        for side in SIDES
    )
    contacts = ((*left, *_resultant(left)), (*right, *_resultant(right)))
    return _Fit(wTo=slid, width=width, drag=abs(offset), contacts=contacts)


def _resultant(patches: Sequence[Contact]) -> list[Contact]:
    """The mean contact of several patches on one pad, as on the inner rim of a cup."""
    if len(patches) < 2:
        return []
    normal = np.sum([n for _, n in patches], axis=0)
    length = float(np.linalg.norm(normal))
    if length < 1e-6:
        return []
    return [(np.mean([p.mean(axis=0) for p, _ in patches], axis=0)[None], normal / length)]


def _turned_flush(hand: Hand, opening: float, target: SimObject, fit: _Fit) -> tuple[_Fit, float]:
    """Let the pads turn an object, downhill in width, until it can be held or turns no further.

    What it lies on does not give way: if it has sunk in by that, it rises between the pads.

    Returns:
        The object as it was turned, and the angle of `_opposition` there [rad].
    """
    enough = np.arctan(target.friction)
    for _ in range(_MAX_TURNS):
        if _opposition(fit) <= enough:
            break
        turned = [
            candidate
            for axis in (hand.wTe.rotation[:, 2], hand.wTe.rotation[:, 0])
            for sign in (1.0, -1.0)
            if (candidate := _fit(hand, opening, target, _turn(fit, sign * _TURN_STEP * axis)))
            is not None
        ]
        best = min(turned, key=lambda candidate: candidate.width, default=fit)
        if best.width > fit.width - _MIN_GAIN:
            break
        fit = best
    sunk = target.reach(_DOWN, fit.wTo) - target.reach(_DOWN)
    if sunk > _SINKS:
        raised = SE3(fit.wTo.rotation, fit.wTo.translation - sunk * _DOWN)
        fit = _fit(hand, opening, target, raised) or fit
    return fit, _opposition(fit)


def _turn(fit: _Fit, rotation: Array) -> SE3:
    """The object turned by a rotation vector [rad] about the middle of its contacts."""
    points = np.vstack([p for side in fit.contacts for p, _ in side] or [fit.wTo.translation])
    centre, turn = points.mean(axis=0), exp3(rotation)
    return SE3(turn @ fit.wTo.rotation, centre + turn @ (fit.wTo.translation - centre))


def _opposition(fit: _Fit) -> float:
    """Smallest angle between a line joining the two sides and the worse of its normals [rad]."""
    left, right = fit.contacts
    return min((_angle(a, b) for a in left for b in right), default=np.pi)


def _angle(left: Contact, right: Contact) -> float:
    (p, n), (q, m) = left, right
    p, q = np.vstack([p, p.mean(axis=0)]), np.vstack([q, q.mean(axis=0)])
    lines = (q[None] - p[:, None]).reshape(-1, 3)
    lines = lines / np.maximum(np.linalg.norm(lines, axis=1, keepdims=True), 1e-12)
    cosine = np.minimum(lines @ n, -(lines @ m)).max()
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _pushed_into(target: SimObject, wTo: SE3, neighbours: Sequence[Geom]) -> bool:
    """Whether an object that moves to `wTo` is pressed sideways into a neighbour."""
    for before, after in zip(target.placed(), target.placed(wTo), strict=True):
        for neighbour in neighbours:
            gap, normal = separation(after, neighbour)
            sideways = abs(normal[2]) < 0.7
            if gap < -_BLOCK and sideways and gap < separation(before, neighbour)[0] - _BLOCK:
                return True
    return False


def _overlap(hand: Hand, fit: _Fit) -> float:
    """Overlap of pads and object along the approach, on the side where it is less [m]."""
    approach = hand.wTe.rotation[:, 2]
    tips = approach @ hand.wTe.translation + hand.gripper.tip
    return min(
        max((float((tips - points @ approach).max()) for points, _ in side), default=-np.inf)
        for side in fit.contacts
    )
