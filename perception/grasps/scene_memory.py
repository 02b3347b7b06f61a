"""Memory of earlier images, for where the newest one shows nothing.

From near, an image is narrower than the hand, and a wall beside an object hides what is behind it;
mostly the camera has seen that on its way there.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from math import ceil
from typing import Generic, NamedTuple, TypeVar

import cv2
import numpy as np

from config.arrays import Array, Indices
from perception.detected_grasp import GraspEstimate
from perception.grasps.height_map import HeightMap, hide_outside
from perception.grasps.view import MIN_OBJECT_HEIGHT

OLDEST = 2.0  # age from which on an image no longer counts [s]
_APART = 0.4  # time between remembered images [s]
_AROUND = 0.12  # reach of a hand around the newest image [m]
_NEAR = 0.015  # what is this near to a grasp, along x or y, may be its object [m]

T = TypeVar("T")


class _Shown(NamedTuple, Generic[T]):
    stamp: float
    what: T


class SceneMemory:
    """Height maps of the last seconds."""

    def __init__(self) -> None:
        self._shown: deque[_Shown[HeightMap]] = deque()
        self._raised: deque[_Shown[Array]] = deque()

    def raised(self, points: Array, stamp: float) -> Array:
        """(N, 3) what stands out in the newest image and in earlier ones, in odometry [m].

        Args:
            points: (M, 3) of the newest image, which are remembered.
            stamp: of the image [s].
        """
        return np.concatenate([points, *_earlier(self._raised, _Shown(stamp, points))])

    def completed(self, scene: HeightMap, stamp: float) -> HeightMap:
        """Remember the newest height map, and complete it by earlier ones."""
        if self._shown and not _same_frame(self._shown[0].what, scene):
            self._shown.clear()  # seen along another approach
        return completed(scene, _earlier(self._shown, _Shown(stamp, scene)))

    def without(self, moving: GraspEstimate, floor: float) -> SceneMemory:
        """A copy without the object at a moving grasp."""
        left, lowest = SceneMemory(), floor + MIN_OBJECT_HEIGHT
        for stamp, scene in self._shown:
            then = moving.oTg_at(stamp).translation
            left._shown.append(_Shown(stamp, _without(scene, then, lowest)))
        return left


def _earlier(shown: deque[_Shown[T]], newest: _Shown[T]) -> list[T]:
    """What was shown in the last seconds before the newest image, which is remembered, too."""
    while shown and not 0.0 <= newest.stamp - shown[-1].stamp <= OLDEST:
        shown.pop()
    earlier = [one.what for one in shown]
    if not shown or newest.stamp - shown[0].stamp >= _APART:
        shown.appendleft(newest)
    return earlier


def _same_frame(one: HeightMap, other: HeightMap) -> bool:
    if one.oRa is None or other.oRa is None:
        return one.oRa is other.oRa
    return np.array_equal(one.oRa, other.oRa)


def _without(scene: HeightMap, point: Array, lowest: float) -> HeightMap:
    """A map in which the objects at or near a point in odometry are unknown."""
    if scene.unknown is None:
        return scene
    if scene.oRa is not None:
        point = point @ scene.oRa
    raised = scene.above(lowest) & ~scene.unknown
    reach = np.arange(-_NEAR, _NEAR + scene.cell, scene.cell)
    near = scene.cells(point[0] + reach[None, :], point[1] + reach[:, None])
    if not raised.ravel()[near].any():
        return scene
    _, objects = cv2.connectedComponents(raised.astype(np.uint8), connectivity=8)
    there = np.setdiff1d(objects.ravel()[near], [0])
    gone = cv2.dilate(np.isin(objects, there).astype(np.uint8), np.ones((5, 5), dtype=np.uint8))
    return replace(scene, unknown=scene.unknown | (gone > 0))


def completed(scene: HeightMap, earlier: Iterable[HeightMap]) -> HeightMap:
    """A map in and around which every unknown cell is that of the first other map that shows it."""
    if scene.unknown is None:
        return scene
    others = [
        (other, other.unknown, _corner(scene, other))
        for other in earlier
        if other.unknown is not None
    ]
    shape = np.array(scene.heights.shape)
    first, end = np.zeros(2, dtype=np.int64), shape
    for other, _, corner in others:
        first = np.minimum(first, corner)
        end = np.maximum(end, corner + other.heights.shape)
    reach = ceil(_AROUND / scene.cell)
    first, end = np.maximum(first, -reach), np.minimum(end, shape + reach)
    wider = tuple(zip(-first, end - shape, strict=True))
    heights = np.pad(scene.heights, wider, mode="edge")
    unknown = np.pad(scene.unknown, wider, constant_values=True)
    for other, hidden, corner in others:
        begin = np.maximum(corner - first, 0)
        stop = np.maximum(np.minimum(corner - first + other.heights.shape, end - first), begin)
        here = tuple(map(slice, begin, stop))
        there = tuple(map(slice, begin + first - corner, stop + first - corner))
        shown = unknown[here] & ~hidden[there]
        np.copyto(heights[here], other.heights[there], where=shown)
        unknown[here] ^= shown
    hide_outside(unknown)
    rising = None if scene.rising is None else np.pad(scene.rising, wider) & unknown
    return replace(
        scene,
        heights=heights,
        origin=scene.origin + scene.cell * first[::-1],
        unknown=unknown,
        rising=rising,
    )


def _corner(scene: HeightMap, other: HeightMap) -> Indices:
    """(2,) row and column of a map in which cell (0, 0) of another lies."""
    return np.rint((other.origin - scene.origin) / scene.cell).astype(np.int64)[::-1]
