"""Local search around what the network proposes: turn, centre, and keep what the hand can do.

Every proposal is tried in some directions, the network's own counting most, and the best few again
after moving to the middle between their contacts and turning square to them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from perception.arrays import Array, Indices
from perception.grasp_feasibility import Assessment, assess
from perception.height_map import HeightMap

ALL_DIRECTIONS = 12
"""So many closing directions leave none out."""
TURN_COST = 0.3
"""Share of its score that a grasp loses at right angles to the network's direction."""
SECOND_ROUND = 8
"""How many of the first round are tried again, centred and turned."""
MAX_TURN = 0.3
"""No further does a grasp turn to be square to its contacts [rad]."""
SAME_DISTANCE = 0.010
"""Grasps nearer than this ... [m]"""
SAME_ANGLE = np.radians(25.0)
"""... and turned by less than this are the same, and the better one stays [rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RefinedGrasps:
    """Grasps that passed the check, best first."""

    x: Array
    """(N,) centre in the world [m]."""
    y: Array
    """(N,) [m]."""
    z: Array
    """(N,) [m]."""
    top: Array
    """(N,) height of the surface above the centre [m]."""
    direction: Array
    """(N,) closing direction in the world, from x towards y [rad]."""
    width: Array
    """(N,) opening that the object needs [m]."""
    opening: Array
    """(N,) between the pads while the hand comes down, so that the fingers touch nothing [m]."""
    score: Array
    """(N,) 0 to 1."""


def refine(
    scene: HeightMap,
    x: Array,
    y: Array,
    direction: Array,
    quality: Array,
    floor: float,
    *,
    directions: int = ALL_DIRECTIONS,
    count: int = 8,
) -> RefinedGrasps:
    """Check proposals on the measured heights and improve them.

    Args:
        scene: measured heights.
        x: (N,) proposed centres in the world [m].
        y: (N,) [m].
        direction: (N,) proposed closing directions, from x towards y [rad].
        quality: (N,) how good the network holds them to be, 0 to 1.
        floor: height of what the objects stand on [m].
        directions: how many are tried at each proposal, evenly from the proposed one on.
        count: how many to give at most.
    """
    turns = np.arange(directions) * np.pi / directions
    tried = (direction[:, None] + turns[None, :]).ravel()
    x, y, proposed, prior = (
        np.repeat(values, directions) for values in (x, y, direction, np.sqrt(quality))
    )
    first = assess(scene, x, y, tried, floor)
    score = first.score * prior * _preference(tried - proposed)
    best = np.argsort(-score, kind="stable")[:SECOND_ROUND]
    best = best[score[best] > 0.0]

    again = np.concatenate([best, best])
    turn = np.concatenate([np.zeros(len(best)), np.clip(first.turn[best], -MAX_TURN, MAX_TURN)])
    second = assess(scene, first.x[again], first.y[again], tried[again] + turn, floor)
    both = _joined(first, best, second)
    origin = np.concatenate([best, again])
    tried = np.concatenate([tried[best], tried[again] + turn])
    off_centre = np.clip(1.2 - np.abs(both.offset) / 0.010, 0.1, 1.0)
    score = both.score * prior[origin] * _preference(tried - proposed[origin]) * off_centre
    kept = _distinct(both, tried, score, count)
    return RefinedGrasps(
        x=both.x[kept],
        y=both.y[kept],
        z=both.z[kept],
        top=both.top[kept],
        direction=tried[kept],
        width=both.width[kept],
        opening=both.opening[kept],
        score=score[kept],
    )


def _preference(turn: Array) -> Array:
    """1 for the network's own direction, less the more a grasp is turned from it."""
    preference: Array = 1.0 - TURN_COST * np.sin(turn) ** 2
    return preference


def _joined(first: Assessment, best: Indices, second: Assessment) -> Assessment:
    parts = {
        f.name: np.concatenate([getattr(first, f.name)[best], getattr(second, f.name)])
        for f in fields(Assessment)
    }
    return Assessment(**parts)


def _distinct(grasps: Assessment, direction: Array, score: Array, count: int) -> list[int]:
    """Indices, best first, without those that are nearly a better one."""
    kept: list[int] = []
    for index in np.argsort(-score, kind="stable"):
        if score[index] <= 0.0 or len(kept) == count:
            break
        distance = np.hypot(grasps.x[kept] - grasps.x[index], grasps.y[kept] - grasps.y[index])
        turn = np.abs((direction[kept] - direction[index] + np.pi / 2) % np.pi - np.pi / 2)
        if not ((distance < SAME_DISTANCE) & (turn < SAME_ANGLE)).any():
            kept.append(int(index))
    return kept
