"""Objects in a height map: their centroids, for the lever arm of a grasp, and their outlines.

The weight of an object turns it about the line between the pads; the farther the grasp is from its
centroid, the easier it slips. An object is a connected region above the floor; its centroid is that
of the volume below its upper surface.
"""

from typing import NamedTuple

import cv2
import numpy as np

from config.arrays import Array, Indices, Mask
from perception.frame import Workspace
from perception.grasps.height_map import HeightMap
from perception.grasps.stereo import TALLEST

LONGEST = 0.08  # a lever arm of this length or more counts as ... [m]
LEAST = 0.2  # ... this share of a grasp at the centroid
_STEP = 2  # only every second row and column is counted [cells]


class ObjectsAt(NamedTuple):
    """The objects at N positions: of each the way to its centroid, what it holds, what is seen."""

    to_x: Array  # (N,) [m]; as all lengths 0 where there is no object
    to_y: Array  # (N,) [m]
    lever: Array  # (N,) how far that is [m]
    volume: Array  # (N,) below its upper surface [m^3]
    whole: Mask  # (N,) whether the border of the image does not cut it off
    clear: Mask  # (N,) whether there is one, and nothing beside it is hidden either


class ObjectCentroids:
    """Connected objects of a height map and their centroids.

    Args:
        scene: measured heights.
        lowest: height in odometry above which points belong to objects [m].
        workspace: limits the objects, in odometry; None is everywhere.
        border: (B, 3) points along the border of the image, in odometry [m]. The centroid
            of an object that it cuts off is unknown. In a if the map is.
    """

    def __init__(
        self,
        scene: HeightMap,
        lowest: float,
        workspace: Workspace | None,
        border: Array | None = None,
    ) -> None:
        self._map = scene = scene.every(_STEP)
        raised = scene.above(lowest)
        if scene.unknown is not None:  # there the map goes on as high as what it ends with
            raised &= ~scene.unknown
        row, column = np.nonzero(raised)
        x, y = scene.origin[0] + column * scene.cell, scene.origin[1] + row * scene.cell
        z = scene.heights[row, column]
        if workspace is not None:
            inside = workspace.contains(scene.in_world(np.stack([x, y, z], axis=1)))
            raised[row[~inside], column[~inside]] = False
            row, column = row[inside], column[inside]
            x, y, z = x[inside], y[inside], z[inside]
        count, objects = cv2.connectedComponents(raised.view(np.uint8), connectivity=8)
        self._objects = np.asarray(objects, dtype=np.float32)
        number, above = objects[row, column], z - scene.plane(lowest, x, y)
        if scene.oRa is not None:  # the floor may be far behind the object
            above = np.minimum(above, TALLEST)
        volume = np.maximum(np.bincount(number, above, count), 1e-9)
        self._volume = volume * scene.cell**2
        self._middle_x = np.bincount(number, above * x, count) / volume
        self._middle_y = np.bincount(number, above * y, count) / volume
        self._outlines: dict[int, Array] = {}
        self._cut_off = np.zeros(count, dtype=np.bool_)
        self._hidden = np.zeros(count, dtype=np.bool_)
        if scene.unknown is not None:  # what is beside it may be more of it
            beside = cv2.dilate(self._objects, np.ones((3, 3), dtype=np.uint8))
            self._hidden[beside[scene.unknown].astype(np.int64)] = True
            self._hidden[0] = False
        if border is not None:
            x, y, z = border.T
            leaving = z > scene.plane(lowest, x, y)
            self._cut_off[self._object_at(x[leaving], y[leaving])] = True
            self._cut_off[0] = False

    def _object_at(self, x: Array, y: Array) -> Indices:
        """(N,) the number of the object there; 0 is none."""
        return self._objects.ravel().take(self._map.cells(x, y)).astype(np.int64)

    def at(self, x: Array, y: Array) -> ObjectsAt:
        """The objects at (N,) positions [m]."""
        number = self._object_at(x, y)
        there, cut_off = number > 0, self._cut_off[number]
        to_x = np.where(there, self._middle_x[number] - x, 0.0)
        to_y = np.where(there, self._middle_y[number] - y, 0.0)
        return ObjectsAt(
            to_x=to_x,
            to_y=to_y,
            lever=np.hypot(to_x, to_y),
            volume=np.where(there, self._volume[number], 0.0),
            whole=~cut_off,
            clear=there & ~cut_off & ~self._hidden[number],
        )

    def outline(self, x: float, y: float) -> Array:
        """(K, 2) x, y of the corners of the convex hull of the object there, in odometry [m]."""
        number = int(self._object_at(np.array([x]), np.array([y]))[0])
        if number not in self._outlines:
            cells = cv2.findNonZero((self._objects == number).view(np.uint8))
            self._outlines[number] = self._map.origin + self._map.cell * cv2.convexHull(cells)[:, 0]
        return self._outlines[number]

    def preference(self, x: Array, y: Array) -> Array:
        """(N,) 1 for grasps at the centroid of an object, less for those farther from it."""
        return np.maximum(1.0 - self.at(x, y).lever / LONGEST, LEAST)
