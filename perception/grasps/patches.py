"""Height patches around grasps, in their own frames: the input of the hold network.

Two height maps, one as large as the open hand and one as large as long objects, rows across the
closing direction and columns along it; and scalars.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from config.arrays import Array, Image, Indices, Mask
from config.planar import act, rotate
from perception.grasps.feasibility import Assessment
from perception.grasps.height_map import HeightMap
from perception.grasps.object_centroids import ObjectCentroids

NEAR_CELL, NEAR_SHAPE = 0.0025, (32, 48)  # cell [m] and shape of the map as large as the hand
FAR_CELL, FAR_SHAPE = 0.010, (32, 32)  # the same of the map as large as long objects
NUMBERS = (
    "score",
    "width",
    "opening",
    "depth",
    "height",
    "middle_along",
    "middle_across",
    "volume",
    "whole",
    "camera_distance",
    "camera_cosine",
)
"""Columns of `GraspPatches.numbers`."""
_FARTHEST = 0.3  # heights are clipped to this above and below the grasp [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class GraspPatches:
    """Height patches and scalars of N grasps."""

    near: npt.NDArray[np.float16]  # (N, 32, 48) heights relative to the grasp [m]
    near_unknown: Mask  # (N, 32, 48) where something hidden may stand
    far: npt.NDArray[np.float16]  # (N, 32, 32) as `near`
    far_unknown: Mask  # (N, 32, 32) as `near_unknown`
    numbers: Image
    """(N, 11) see `NUMBERS`: score of the check; lengths in m, of the grasp over the floor and
    below the surface, from it to the centroid along and across, and to the camera; volume of the
    object in m^3; whether it is all in the image; cosine between the way to the camera and that
    from which the hand comes.
    """

    def only(self, which: Indices) -> GraspPatches:
        """A selection of them."""
        return GraspPatches(**{f.name: getattr(self, f.name)[which] for f in fields(self)})


HoldProbability: TypeAlias = Callable[[GraspPatches], Array]
"""(N,) how likely each of N grasps holds without a hard contact."""


def grasp_patches(
    scene: HeightMap, found: Assessment, centroids: ObjectCentroids, camera: Array, floor: float
) -> GraspPatches:
    """Height patches and scalars of grasps; `camera` (3,) is in the frame of the map [m]."""
    near, near_unknown = _around(scene, found, NEAR_CELL, NEAR_SHAPE)
    far, far_unknown = _around(scene, found, FAR_CELL, FAR_SHAPE)
    objects = centroids.at(found.x, found.y)
    along, across = rotate(-found.direction, objects.to_x, objects.to_y)
    to_camera = camera - np.stack([found.x, found.y, found.z], axis=1)
    distance = np.linalg.norm(to_camera, axis=1)
    columns = {
        "score": found.score,
        "width": found.width,
        "opening": found.opening,
        "depth": found.top - found.z,
        "height": scene.over(floor, found.x, found.y, found.z),
        "middle_along": along,
        "middle_across": across,
        "volume": objects.volume,
        "whole": objects.whole,
        "camera_distance": distance,
        "camera_cosine": to_camera[:, 2] / distance,
    }
    return GraspPatches(
        near=near,
        near_unknown=near_unknown,
        far=far,
        far_unknown=far_unknown,
        numbers=np.stack([columns[name] for name in NUMBERS], axis=1).astype(np.float32),
    )


def _around(
    scene: HeightMap, found: Assessment, cell: float, shape: tuple[int, int]
) -> tuple[npt.NDArray[np.float16], Mask]:
    """Heights relative to each grasp on a grid in its frame [m], and what is unknown there."""
    rows, columns = shape
    across = (np.arange(rows) - 0.5 * (rows - 1))[None, :, None] * cell
    along = (np.arange(columns) - 0.5 * (columns - 1))[None, None, :] * cell
    grasps = np.stack([found.x, found.y, found.direction])[:, :, None, None]
    cells = scene.cells(*act(grasps, along, across))
    heights = scene.heights.ravel().take(cells) - found.z[:, None, None]
    unknown: Mask = np.zeros(heights.shape, dtype=np.bool_)
    if scene.unknown is not None:
        unknown = scene.unknown.ravel().take(cells)
    return np.clip(heights, -_FARTHEST, _FARTHEST).astype(np.float16), unknown
