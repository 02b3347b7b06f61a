"""Local search around candidates for feasible grasps.

Every candidate is assessed in all closing directions, preferably those near its own: the direction
of GG-CNN may be the average of several good ones. The best are assessed again after centring
between their contacts and turning perpendicular to them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from config.arrays import Array, Indices, Mask
from perception.grasps.feasibility import Assessment, assess
from perception.grasps.height_map import HeightMap
from perception.grasps.object_centroids import ObjectCentroids
from robots import GripperDescription

DIRECTIONS = 12  # closing directions tried at a candidate, in steps of 15° over the half turn
TURN_COST = 0.3  # share of its score that a grasp loses at right angles to its candidate
MAX_TURN = 0.3  # largest turn towards the normal of the contacts [rad]
SAME_DISTANCE = 0.010  # two grasps at less than this distance [m] ...
SAME_ANGLE = np.radians(25.0)  # ... and angle [rad] are duplicates
_MOST_SLANT = 0.35  # sine of the slant of a closing direction from which on it counts as ...
_LEAST_UPRIGHT = 0.3  # ... this much
_CENTRED = 0.010  # offset from the contacts' middle at which a score is down to a fifth [m]


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
    owned: Callable[[Assessment], Mask] | None = None,
) -> Assessment:
    """Refine candidates on the measured heights.

    Args:
        scene: measured heights.
        x: (N,) centres of the candidates in odometry [m].
        y: (N,) [m].
        direction: (N,) their closing directions, from x towards y [rad].
        quality: (N,) their quality by the network, 0 to 1.
        floor: height of the support surface [m].
        gripper: the hand.
        directions: number tried at each candidate, evenly over the half turn.
        turn_cost: see `TURN_COST`.
        count: largest number of grasps that are assessed again and returned.
        centroids: to prefer grasps near the middle of objects; None does not.
        owned: to which of assessed grasps are allowed; None allows all.

    Returns:
        The feasible ones, best first.
    """

    def judged(
        found: Assessment, prior: Array, proposed: Array, centred: Array | float = 1.0
    ) -> Assessment:
        score = found.score * prior * centred
        score *= _preference(found.direction - proposed, turn_cost)
        score *= uprightness(found.direction, scene.oRa)
        if centroids is not None:
            score *= centroids.preference(found.x, found.y)
        if owned is not None:
            score *= owned(found)
        return replace(found, score=score)

    turns = np.arange(directions) * np.pi / directions
    tried = (direction[:, None] + turns[None, :]).ravel()
    x, y, proposed, prior = (
        np.repeat(values, directions) for values in (x, y, direction, np.sqrt(quality))
    )
    first = judged(assess(scene, x, y, tried, floor, gripper), prior, proposed)
    best = np.argsort(-first.score, kind="stable")[:count]
    best = best[first.score[best] > 0.0]

    turns = np.clip(first.turn[best], -MAX_TURN, MAX_TURN)
    again, turns = np.concatenate([best, best]), np.concatenate([np.zeros(len(best)), turns])
    found = assess(scene, first.x[again], first.y[again], tried[again] + turns, floor, gripper)
    off_centre = np.clip(1.2 - np.abs(found.offset) / _CENTRED, 0.1, 1.0)
    found = judged(found, prior[again], proposed[again], off_centre)
    return found.only(_distinct(found, count))


def _preference(turn: Array, cost: float) -> Array:
    """1 for the candidate's own direction, less for a grasp turned from it."""
    preference: Array = 1.0 - cost * np.sin(turn) ** 2
    return preference


def _distinct(grasps: Assessment, count: int) -> Indices:
    """Indices of the best, best first, without duplicates of a better one."""
    score, direction, kept = grasps.score, grasps.direction, np.zeros(0, dtype=np.int64)
    for index in np.argsort(-score, kind="stable"):
        if score[index] <= 0.0 or len(kept) == count:
            break
        distance = np.hypot(grasps.x[kept] - grasps.x[index], grasps.y[kept] - grasps.y[index])
        turn = np.abs((direction[kept] - direction[index] + np.pi / 2) % np.pi - np.pi / 2)
        if not ((distance < SAME_DISTANCE) & (turn < SAME_ANGLE)).any():
            kept = np.append(kept, index)
    return kept


def level_direction(oRa: Array) -> float:
    """The closing direction in a that is level in the world, from x towards y [rad]."""
    return float(np.arctan2(-oRa[2, 0], oRa[2, 1]))


def uprightness(direction: Array, oRa: Array | None) -> Array:
    """(N,) 1 for closing directions in a that are level in the world, to 0.3 for slanted ones.

    The sides of most objects are upright: pads that close on them at a slant turn the object.
    """
    if oRa is None:
        return np.ones(len(direction))
    slant = np.cos(direction) * oRa[2, 0] + np.sin(direction) * oRa[2, 1]
    lost = (1.0 - _LEAST_UPRIGHT) * np.minimum((slant / _MOST_SLANT) ** 2, 1.0)
    upright: Array = 1.0 - lost
    return upright
