"""Objects in a height map: their centroids, for the lever arm of a grasp, and their outlines.

The weight of an object turns it about the line between the pads; the farther the grasp is from its
centroid, the easier it slips. An object is a connected region above the floor; its centroid is that
of the volume below its upper surface.
"""

import cv2
import numpy as np

from perception.frame import Array, Indices, Mask, Workspace
from perception.grasps.height_map import HeightMap, look_up
from perception.grasps.stereo import TALLEST

LONGEST = 0.08  # a lever arm of this length or more counts as ... [m]
LEAST = 0.2  # ... this share of a grasp at the centroid
_STEP = 2  # only every second row and column is counted [cells]


class ObjectCentroids:
    """Connected objects of a height map and their centroids.

    Args:
        scene: measured heights.
        lowest: height in the world above which points belong to objects [m].
        workspace: limits the objects; None is everywhere.
        border: (B, 3) points along the border of the image, in the world [m]. The centroid
            of an object that it cuts off is unknown. As all else in a if the map is.
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
        raised = scene.above(lowest)[::_STEP, ::_STEP]
        if scene.unknown is not None:  # there the map goes on as high as what it ends with
            raised &= ~scene.unknown[::_STEP, ::_STEP]
        row, column = np.nonzero(raised)
        x, y = scene.origin[0] + column * self._cell, scene.origin[1] + row * self._cell
        if workspace is not None:
            inside = workspace.contains(np.stack([x, y, heights[row, column]], axis=1))
            raised[row[~inside], column[~inside]] = False
            row, column, x, y = row[inside], column[inside], x[inside], y[inside]
        count, objects = cv2.connectedComponents(raised.astype(np.uint8), connectivity=8)
        self._objects = np.asarray(objects, dtype=np.float32)
        number, above = objects[row, column], heights[row, column] - scene.plane(lowest, x, y)
        if scene.wRa is not None:  # the floor may be far behind the object
            above = np.minimum(above, TALLEST)
        volume = np.maximum(np.bincount(number, above, count), 1e-9)
        self._volume = volume * self._cell**2
        self._middle_x = np.bincount(number, above * x, count) / volume
        self._middle_y = np.bincount(number, above * y, count) / volume
        self._outlines: dict[int, Array] = {}
        self._cut_off = np.zeros(count, dtype=np.bool_)
        self._hidden = np.zeros(count, dtype=np.bool_)
        if scene.unknown is not None:  # what is beside it may be more of it
            beside = cv2.dilate(self._objects, np.ones((3, 3), dtype=np.uint8))
            self._hidden[beside[scene.unknown[::_STEP, ::_STEP]].astype(np.int64)] = True
            self._hidden[0] = False
        if border is not None:
            x, y, z = border.T
            leaving = z > scene.plane(lowest, x, y)
            self._cut_off[self._object_at(x[leaving], y[leaving])] = True
            self._cut_off[0] = False

    def _object_at(self, x: Array, y: Array) -> Indices:
        """(N,) the number of the object there; 0 is none."""
        return look_up(self._objects, self._origin, self._cell, x, y).astype(np.int64)

    def to_middle(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The way to the centroid of the object at (N,) positions [m]; 0 without one."""
        number = self._object_at(x, y)
        there = number > 0
        return (
            np.where(there, self._middle_x[number] - x, 0.0),
            np.where(there, self._middle_y[number] - y, 0.0),
        )

    def at(self, x: Array, y: Array) -> Array:
        """Lever arms of grasps at (N,) positions in the world [m]; 0 without an object."""
        arm: Array = np.hypot(*self.to_middle(x, y))
        return arm

    def volume(self, x: Array, y: Array) -> Array:
        """Of the objects at (N,) positions, below their upper surface [m^3]; 0 for none."""
        number = self._object_at(x, y)
        return np.where(number > 0, self._volume[number], 0.0)

    def outline(self, x: float, y: float) -> Array:
        """(K, 2) x, y of the corners of the convex hull of the object there, in the world [m]."""
        number = int(self._object_at(np.array([x]), np.array([y]))[0])
        if number not in self._outlines:
            cells = cv2.findNonZero((self._objects == number).astype(np.uint8))
            self._outlines[number] = self._origin + self._cell * cv2.convexHull(cells)[:, 0]
        return self._outlines[number]

    def preference(self, x: Array, y: Array) -> Array:
        """(N,) 1 for grasps at the centroid of an object, less for those farther from it."""
        return np.maximum(1.0 - self.at(x, y) / LONGEST, LEAST)

    def shows_all(self, x: Array, y: Array) -> Mask:
        """(N,) whether the image shows all of the object there."""
        return ~self._cut_off[self._object_at(x, y)]

    def shows_middle(self, x: Array, y: Array) -> Mask:
        """(N,) whether the image shows all of an object there, and around it."""
        number = self._object_at(x, y)
        return (number > 0) & ~self._cut_off[number] & ~self._hidden[number]
