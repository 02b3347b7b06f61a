"""Which parts of an arm can touch each other: by its SRDF, or by random postures.

As MoveIt's setup assistant does: neighbours, pairs that are nearly always in contact and pairs that
never come near each other are left out.
"""

from __future__ import annotations

from itertools import combinations, product
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config.arrays import Array, Mask
from extensions.urdf.arm_choice import Arm
from robots import Geom, coal_geometry

_DRAWN, _SEED = 2000, 5
_OFTEN = 0.6  # share of postures in contact from which a pair is left out
_ALWAYS = 0.9, 0.03  # so is one that is as near as this in that share of postures [m]
_NEVER = 0.05  # so is one that never comes as near as this [m]


class Part(NamedTuple):
    """A part: shapes that one joint moves, in its frame (0: in the base)."""

    name: str
    joint: int
    shapes: list[Geom] | tuple[float, ...] | None  # a box on the floor; None is the floor
    links: set[str]  # of the URDF


def touching(
    arm: Arm,
    parts: list[Part],
    joints: list[SE3],
    slides: Mask,
    notes: list[str],
) -> list[list[list[str]]]:
    """Pairs of parts that can touch, as a robot file has them; `joints` are one on the other."""
    chain, joint = pin.Model(), 0
    for number, (place, slide) in enumerate(zip(joints, slides.tolist(), strict=True)):
        kind = pin.JointModelPZ() if slide else pin.JointModelRZ()
        joint = chain.addJoint(joint, kind, place, f"joint{number}")
    geometry = pin.GeometryModel()
    numbers = {part.name: _add(part, geometry) for part in parts}
    shaped = [part for part in parts if numbers[part.name]]
    pairs = [pair for pair in combinations(shaped, 2) if _counts(*pair, arm)]
    columns = []
    for one, other in pairs:
        first = len(geometry.collisionPairs)
        for a, b in product(numbers[one.name], numbers[other.name]):
            geometry.addCollisionPair(pin.CollisionPair(a, b))
        columns.append(slice(first, len(geometry.collisionPairs)))
    data, results = chain.createData(), pin.GeometryData(geometry)
    nearest = np.full((_DRAWN, len(pairs)), np.inf)
    for row, q in zip(nearest, postures(arm), strict=True):
        pin.computeDistances(chain, data, geometry, results, q)
        d = np.array([one.min_distance for one in results.distanceResults])
        row[:] = [d[column].min(initial=np.inf) for column in columns]
    kept, left_out = [], []
    for pair, away in zip(pairs, nearest.T, strict=True):
        inner, outer = sorted(pair, key=lambda one: one.joint)
        if (away < 0.0).mean() > _OFTEN or np.quantile(away, _ALWAYS[0]) < _ALWAYS[1]:
            left_out.append(f"{inner.name}-{outer.name}")
        elif away.min() < _NEVER:
            kept.append([[inner.name], [outer.name]])
    if left_out:
        notes.append(f"not watched, as always near each other: {', '.join(left_out)} (--srdf)")
    return kept


def _counts(one: Part, other: Part, arm: Arm) -> bool:
    """Whether two parts can move against each other, and the SRDF does not let them touch."""
    low, high = sorted((one.joint, other.joint))
    if low == high or (high - low == 1 and "floor" not in (one.name, other.name)):
        return False
    if "floor" in (one.name, other.name):
        return high > 1
    shaped = {arm.link_of(shape) for shape in arm.geometry.geometryObjects}
    links = list(product(one.links & shaped, other.links & shaped))
    return not links or not all(frozenset(pair) in arm.disabled for pair in links)


def _add(part: Part, geometry: pin.GeometryModel) -> list[int]:
    shapes: list[tuple[SE3, object]] = []
    if part.shapes is None:
        shapes = [(SE3.Identity(), coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0))]
    elif isinstance(part.shapes, tuple):
        middle = SE3(np.eye(3), np.array([0.0, 0.0, part.shapes[2] / 2.0]))
        shapes = [(middle, coal.Box(*part.shapes))]
    else:
        shapes = [(one.pose, coal_geometry(one.shape)) for one in part.shapes]
    named = ((f"{part.name}/{number}", *one) for number, one in enumerate(shapes))
    objects = [pin.GeometryObject(name, part.joint, *one) for name, *one in named]
    return [int(geometry.addGeometryObject(one)) for one in objects]


def postures(arm: Arm) -> Array:
    """(N, j) random positions of its joints [rad, m], the same ones each time."""
    model, ends = arm.model, []
    for joint in model.joints[1:]:
        low, high = -np.pi, np.pi
        if joint.nq == 1:
            low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
        ends.append((-np.pi, np.pi) if high - low > 2.0 * np.pi else (low, high))
    low, high = np.array(ends).T
    return np.random.default_rng(_SEED).uniform(low, high, (_DRAWN, len(ends)))
