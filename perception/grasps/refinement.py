"""Local search around candidates for feasible grasps.

Every candidate is assessed in all closing directions, preferably those near its own: the direction
of GG-CNN may be the average of several good ones. The best are assessed again after centring
between their contacts and turning perpendicular to them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from perception.frame import Array, Indices, Mask
from perception.grasps.approach import uprightness
from perception.grasps.feasibility import Assessment, assess
from perception.grasps.height_map import HeightMap
from perception.grasps.object_centroids import ObjectCentroids
from robots import GripperDescription

DIRECTIONS = 12  # closing directions tried at a candidate, in steps of 15° over the half turn
TURN_COST = 0.3  # share of its score that a grasp loses at right angles to its candidate
MAX_TURN = 0.3  # largest turn towards the normal of the contacts [rad]
SAME_DISTANCE = 0.010  # two grasps at less than this distance [m] ...
SAME_ANGLE = np.radians(25.0)  # ... and angle [rad] are duplicates
_CENTRED = 0.010  # offset from the contacts' middle at which a score is down to a fifth [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class RefinedGrasps:
    """Feasible grasps, best first."""

    x: Array  # (N,) centre in the world [m]
    y: Array  # (N,) [m]
    z: Array  # (N,) [m]
    top: Array  # (N,) height of the surface above the centre [m]
    direction: Array  # (N,) closing direction, from x towards y of the world [rad]
    width: Array  # (N,) distance between the contacts [m]
    opening: Array  # (N,) distance between the pads for a free descent [m]
    score: Array  # (N,) 0 to 1

    def only(self, which: Indices | Mask) -> RefinedGrasps:
        """A selection of them."""
        return RefinedGrasps(**{f.name: getattr(self, f.name)[which] for f in fields(self)})

    def ranked(self, score: Array, preference: Array) -> RefinedGrasps:
        """The same grasps with another score, the most preferred first."""
        return replace(self, score=score).only(np.argsort(-preference, kind="stable"))


def refine(
    scene: HeightMap,
    x: Array,
    y: Array,
    direction: Array,
    quality: Array,
    floor: float,
    gripper: GripperDescription,
    *,
    directions: int = DIRECTIONS,
    turn_cost: float = TURN_COST,
    count: int = 8,
    centroids: ObjectCentroids | None = None,
    owned: Callable[[Assessment, Array], Mask] | None = None,
) -> RefinedGrasps:
    """Refine candidates on the measured heights.

    Args:
        scene: measured heights.
        x: (N,) centres of the candidates in the world [m].
        y: (N,) [m].
        direction: (N,) their closing directions, from x towards y [rad].
        quality: (N,) their quality by the network, 0 to 1.
        floor: height of the support surface [m].
        gripper: the hand.
        directions: number tried at each candidate, evenly over the half turn.
        turn_cost: see `TURN_COST`.
        count: largest number of grasps that are assessed again and returned.
        centroids: to prefer grasps near the middle of objects; None does not.
        owned: (grasps, closing directions) to which of them are allowed; None allows all.
    """
    turns = np.arange(directions) * np.pi / directions
    tried = (direction[:, None] + turns[None, :]).ravel()
    x, y, proposed, prior = (
        np.repeat(values, directions) for values in (x, y, direction, np.sqrt(quality))
    )
    first = assess(scene, x, y, tried, floor, gripper)
    score = first.score * prior * _preference(tried - proposed, turn_cost)
    score *= uprightness(tried, scene.wRa)
    if centroids is not None:
        score *= centroids.preference(first.x, first.y)
    if owned is not None:
        score *= owned(first, tried)
    best = np.argsort(-score, kind="stable")[:count]
    best = best[score[best] > 0.0]

    again = np.concatenate([best, best])
    turn = np.concatenate([np.zeros(len(best)), np.clip(first.turn[best], -MAX_TURN, MAX_TURN)])
    tried = tried[again] + turn
    found = assess(scene, first.x[again], first.y[again], tried, floor, gripper)
    off_centre = np.clip(1.2 - np.abs(found.offset) / _CENTRED, 0.1, 1.0)
    score = found.score * prior[again] * off_centre
    score *= _preference(tried - proposed[again], turn_cost) * uprightness(tried, scene.wRa)
    if centroids is not None:
        score *= centroids.preference(found.x, found.y)
    if owned is not None:
        score *= owned(found, tried)
    kept = _distinct(found, tried, score, count)
    return RefinedGrasps(
        x=found.x[kept],
        y=found.y[kept],
        z=found.z[kept],
        top=found.top[kept],
        direction=tried[kept],
        width=found.width[kept],
        opening=found.opening[kept],
        score=score[kept],
    )


def _preference(turn: Array, cost: float) -> Array:
    """1 for the candidate's own direction, less for a grasp turned from it."""
    preference: Array = 1.0 - cost * np.sin(turn) ** 2
    return preference


def _distinct(grasps: Assessment, direction: Array, score: Array, count: int) -> list[int]:
    """Indices of the best, best first, without duplicates of a better one."""
    kept: list[int] = []
    for index in np.argsort(-score, kind="stable"):
        if score[index] <= 0.0 or len(kept) == count:
            break
        distance = np.hypot(grasps.x[kept] - grasps.x[index], grasps.y[kept] - grasps.y[index])
        turn = np.abs((direction[kept] - direction[index] + np.pi / 2) % np.pi - np.pi / 2)
        if not ((distance < SAME_DISTANCE) & (turn < SAME_ANGLE)).any():
            kept.append(int(index))
    return kept
