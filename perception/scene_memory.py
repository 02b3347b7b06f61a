"""What earlier images showed, for where the newest shows nothing.

From near, an image is narrower than the hand, and a wall beside an object hides what is behind it.
Mostly the camera has seen that on its way there. Where the newest image shows what stands, it alone
counts.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from math import ceil
from typing import NamedTuple

import numpy as np

from perception.arrays import Indices
from perception.height_map import HeightMap, hide_outside

OLDEST = 2.0
"""What an image showed longer ago may have changed [s]."""
_APART = 0.4  # images that are remembered [s]
_AROUND = 0.12  # of the newest image: a hand that grasps in it reaches no farther [m]


class _Shown(NamedTuple):
    stamp: float
    scene: HeightMap


class SceneMemory:
    """What the images of the last seconds showed of a scene in which nothing moves."""

    def __init__(self) -> None:
        self._shown: deque[_Shown] = deque()

    def completed(self, scene: HeightMap, stamp: float) -> HeightMap:
        """The map of the newest image, completed by what those before it showed.

        Args:
            scene: the map; it is remembered.
            stamp: when the image was captured [s].
        """
        while self._shown and not 0.0 <= stamp - self._shown[-1].stamp <= OLDEST:
            self._shown.pop()
        earlier = [shown.scene for shown in self._shown]
        if not self._shown or stamp - self._shown[0].stamp >= _APART:
            self._shown.appendleft(_Shown(stamp, scene))
        return completed(scene, earlier)


def completed(scene: HeightMap, earlier: Iterable[HeightMap]) -> HeightMap:
    """A map in and around which every unknown cell is that of the first other map that shows it.

    Args:
        scene: the map.
        earlier: others of the same world.
    """
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
        heights[here][shown] = other.heights[there][shown]
        unknown[here][shown] = False
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
