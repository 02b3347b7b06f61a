"""How far from its middle a thing is gripped.

The weight of what hangs in the fingers turns it about the line between the pads; the farther the
grasp is from the middle of the thing, the easier it swings, slips and is lost. A thing is what
stands out of the floor by itself; its middle is that of the volume below its upper surface.
"""

from __future__ import annotations

import cv2
import numpy as np

from perception.frame import Array, Indices, Mask, Workspace
from perception.grasps.height_map import HeightMap, look_up

LONGEST = 0.08
"""A lever arm of this length or more counts as ... [m]"""
LEAST = 0.2
"""... this share of a grasp in the middle."""
_STEP = 2  # only every second row and column of the map is counted [cells]


class ObjectCentroids:
    """The things in a height map, and where their middles are.

    Args:
        scene: measured heights.
        lowest: nothing below this height belongs to a thing [m].
        workspace: nothing outside belongs to one; None is everywhere.
        border: (B, 3) points along the border of the image, in the world [m]. Of what it cuts off
            nobody knows the middle.
    """

    def __init__(
        self,
        scene: HeightMap,
        lowest: float,
        workspace: Workspace | None,
        border: Array | None = None,
    ) -> None:
        heights = scene.heights[::_STEP, ::_STEP]
        self._cell = _STEP * scene.cell
        self._origin = scene.origin
        raised = heights > lowest
        if scene.unknown is not None:  # there the map goes on as high as what it ends with
            raised &= ~scene.unknown[::_STEP, ::_STEP]
        row, column = np.nonzero(raised)
        x, y = scene.origin[0] + column * self._cell, scene.origin[1] + row * self._cell
        if workspace is not None:
            inside = workspace.contains(np.stack([x, y, heights[row, column]], axis=1))
            raised[row[~inside], column[~inside]] = False
            row, column, x, y = row[inside], column[inside], x[inside], y[inside]
        count, things = cv2.connectedComponents(raised.astype(np.uint8), connectivity=8)
        self._things = np.asarray(things, dtype=np.float32)
        thing, above = things[row, column], heights[row, column] - lowest
        volume = np.maximum(np.bincount(thing, above, count), 1e-9)
        self._volume = volume * self._cell**2
        self._middle_x = np.bincount(thing, above * x, count) / volume
        self._middle_y = np.bincount(thing, above * y, count) / volume
        self._cut_off = np.zeros(count, dtype=np.bool_)
        self._hidden = np.zeros(count, dtype=np.bool_)
        if scene.unknown is not None:  # what is beside it may be more of it
            beside = cv2.dilate(self._things, np.ones((3, 3), dtype=np.uint8))
            self._hidden[beside[scene.unknown[::_STEP, ::_STEP]].astype(np.int64)] = True
            self._hidden[0] = False
        if border is not None:
            leaving = border[border[:, 2] > lowest]
            self._cut_off[self._thing_at(leaving[:, 0], leaving[:, 1])] = True
            self._cut_off[0] = False

    def _thing_at(self, x: Array, y: Array) -> Indices:
        """(N,) the number of the thing there; 0 is none."""
        return look_up(self._things, self._origin, self._cell, x, y).astype(np.int64)

    def to_middle(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The way to the middle of the thing at (N,) positions [m]; 0 where nothing stands."""
        thing = self._thing_at(x, y)
        there = thing > 0
        return (
            np.where(there, self._middle_x[thing] - x, 0.0),
            np.where(there, self._middle_y[thing] - y, 0.0),
        )

    def at(self, x: Array, y: Array) -> Array:
        """Lever arms of grasps at (N,) positions in the world [m]; 0 where nothing stands."""
        arm: Array = np.hypot(*self.to_middle(x, y))
        return arm

    def volume(self, x: Array, y: Array) -> Array:
        """Of the things at (N,) positions, below their upper surface [m^3]; 0 for none."""
        thing = self._thing_at(x, y)
        return np.where(thing > 0, self._volume[thing], 0.0)

    def preference(self, x: Array, y: Array) -> Array:
        """1 for grasps in the middle of a thing, less for those farther from it; (N,)."""
        return np.maximum(1.0 - self.at(x, y) / LONGEST, LEAST)

    def shows_all(self, x: Array, y: Array) -> Mask:
        """(N,) whether the image shows all of what stands there, and so its middle."""
        return ~self._cut_off[self._thing_at(x, y)]

    def shows_middle(self, x: Array, y: Array) -> Mask:
        """(N,) whether something stands there, and the image shows all of it and around it."""
        thing = self._thing_at(x, y)
        return (thing > 0) & ~self._cut_off[thing] & ~self._hidden[thing]
