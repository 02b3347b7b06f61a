"""A frame as a search for grasps sees it: along an approach, with a workspace and its floor.

The frame a of an approach has the world's origin, and the hand approaches along its -z; `oRa` is
its rotation (3, 3) in odometry. In a, every approach is from straight above, only that level
surfaces are slopes.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from pinocchio import SE3

from config.arrays import Array, Mask
from perception.cloud import DepthCloud
from perception.frame import Frame, Workspace
from perception.geometry import world_points
from perception.grasps.network_input import (
    INPUT_SIZE,
    OUTPUT_STRIDE,
    Crop,
    Prepared,
    scaled_crop,
)
from perception.grasps.stereo import FAR, near_floor_filled, smoothed
from perception.region_map import WALL_MARGIN

MIN_OBJECT_HEIGHT = 0.008  # surfaces lower than this above the floor are not grasped [m]
_OCCUPIED_HEIGHT = 0.010  # ... and than this do not stand out [m]
MAX_CAMERA_AXIS_Z = -0.5  # the optical axis is within 60 degrees of the approach
_FAR_END = 90.0  # of the depths in the workspace that a level camera sees [percent]
_LEVEL_BIN = 0.005  # of the histogram of heights that finds the support surface [m]
_STEP = 3  # only every third row and column of the image is looked at for what stands out [px]
_SPARSE = 8  # ... and this one for what stands in the way of the arm [px]
_MIN_PIXELS = 100  # of the image that a piece outside the middle covers; fewer are noise


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """What is searched."""

    cloud: DepthCloud  # as it was measured
    along: DepthCloud  # in the frame a of the approach, with less noise
    oRa: Array | None  # (3, 3) rotation of a in odometry; None is the world, from straight above
    workspace: Workspace | None  # in odometry; None is everywhere
    floor: float  # height of the support surface in odometry [m]
    support: float  # its depth along the optical axis, or that of its far end, seen level [m]
    stamp: float

    @classmethod
    def of(cls, frame: Frame, workspace: Workspace | None, oRa: Array | None) -> View:
        """A frame, a workspace in odometry and the rotation (3, 3) of the approach."""
        along = cloud = frame.cloud
        support = _support_depth(cloud, workspace)
        floor = _level(cloud) if workspace is None else workspace.floor
        if support > FAR:
            along = smoothed(along)
        if oRa is not None:
            along = near_floor_filled(along, floor).posed(SE3(oRa.T, np.zeros(3)) * cloud.oTc)
        return cls(
            cloud=cloud,
            along=along,
            oRa=oRa,
            workspace=workspace,
            floor=floor,
            support=support,
            stamp=frame.stamp,
        )

    def crop(self, about: Array | None = None) -> Crop:
        """The part that a network sees, about a pixel (2,); None is the middle."""
        return scaled_crop(self.cloud.depth.shape, self.cloud.intrinsics, self.support, about)

    def allowed(self, prepared: Prepared) -> Mask:
        """(300, 300) where a grasp may be: the depth was measured, inside the workspace."""
        middle = np.arange(OUTPUT_STRIDE // 2, INPUT_SIZE, OUTPUT_STRIDE)
        pixel = prepared.crop.to_image(np.stack([middle, middle], axis=1).astype(float))
        u, v = pixel[None, :, 0], pixel[:, None, 1]
        depth = prepared.depth[np.ix_(middle, middle)]
        points = world_points(depth, self.cloud.intrinsics, self.cloud.oTc, u, v)
        allowed = self._well_inside(points, MIN_OBJECT_HEIGHT)
        size = (INPUT_SIZE, INPUT_SIZE)
        enlarged = cv2.resize(allowed.view(np.uint8), size, interpolation=cv2.INTER_NEAREST)
        mask: Mask = (np.asarray(enlarged) > 0) & ~prepared.missing
        return mask

    def stands_out_beside(self, crop: Crop) -> Array | None:
        """(2,) the middle of what stands out nearest to a crop, outside it [px]; or None."""
        row, column, points = self.cloud.every(_STEP)
        high = self._well_inside(points, _OCCUPIED_HEIGHT)
        mask = np.zeros(self.cloud.depth[::_STEP, ::_STEP].shape, dtype=np.uint8)
        mask[row[high] // _STEP, column[high] // _STEP] = 1
        mask[tuple(slice(one.start // _STEP, one.stop // _STEP) for one in crop.window)] = 0
        _, _, stats, middles = cv2.connectedComponentsWithStats(mask)
        pieces = np.asarray(middles[1:])[stats[1:, cv2.CC_STAT_AREA] >= _MIN_PIXELS / _STEP**2]
        if not len(pieces):
            return None
        centre = np.array([crop.u0, crop.v0]) + 0.5 * crop.size
        nearest: Array = _STEP * pieces[np.linalg.norm(_STEP * pieces - centre, axis=1).argmin()]
        return nearest

    def raised(self) -> Array:
        """(N, 3) every few points of the whole image that stand out, in odometry [m]."""
        points = self.cloud.every(_SPARSE).points
        raised: Array = points[points[:, 2] > self.floor + _OCCUPIED_HEIGHT]
        return raised

    def _well_inside(self, points: Array, height: float) -> Mask:
        """Which points (..., 3) are so high over the floor and not near the sides [m]."""
        high = points[..., 2] >= self.floor + height
        if self.workspace is None:
            return np.asarray(high)
        left = np.flatnonzero(high)
        points = points.reshape(-1, 3)[left]
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            inside = self.workspace.contains(points + WALL_MARGIN * np.array([dx, dy, 0.0]))
            left, points = left[inside], points[inside]
        well = np.zeros(high.shape, dtype=np.bool_)
        well.ravel()[left] = True
        return well


def _support_depth(cloud: DepthCloud, workspace: Workspace | None) -> float:
    """Depth of the support surface along the optical axis; or of its far end, seen level [m]."""
    oTc, depth = cloud.oTc, cloud.depth
    if workspace is not None and oTc.rotation[2, 2] <= MAX_CAMERA_AXIS_Z:
        along_axis = float((workspace.floor - oTc.translation[2]) / oTc.rotation[2, 2])
        if along_axis > 0.0:
            return along_axis
    elif workspace is not None:
        row, column, points = cloud.every(_STEP)
        inside = workspace.contains(points)
        if inside.any():
            return float(np.percentile(depth[row[inside], column[inside]], _FAR_END))
    return float(np.median(depth[cloud.valid]))


def _level(cloud: DepthCloud) -> float:
    """Height of the largest level surface in an image [m]."""
    heights = cloud.every(_STEP).points[:, 2]
    bins = np.rint(heights / _LEVEL_BIN).astype(np.int64)
    lowest = int(bins.min())
    level = (int(np.bincount(bins - lowest).argmax()) + lowest) * _LEVEL_BIN
    return float(np.median(heights[np.abs(heights - level) < _LEVEL_BIN]))
