"""Further candidates: pairs of edges that face each other, found on the height map alone."""

from __future__ import annotations

import cv2
import numpy as np

from perception.arrays import Array
from perception.height_map import HeightMap
from robots import GripperDescription

COUNT = 150
"""Edges that a facing one is looked for from."""
_SMOOTHING = 1.2  # of the heights before their slope is taken [cells]
_STEEP = 0.6  # slope of an edge
_LOWEST = 0.006  # an edge is at least this high above the floor [m]
_INWARD = 0.004  # from the middle of an edge to the surface of the thing [m]
_FALL = 0.012  # the surface ends where it is this much lower, or half as high [m]
_STEP = 0.0015  # of the walk across the thing [m]
_NARROWEST = 2  # steps


def antipodal_pairs(
    scene: HeightMap, floor: float, gripper: GripperDescription
) -> tuple[Array, Array, Array]:
    """Middles between an edge and where the surface falls again, straight across the thing.

    Args:
        scene: measured heights.
        floor: height of the support surface [m].
        gripper: the hand; what is wider than it opens is left out.

    Returns:
        x and y in the world [m] and the closing direction, from x towards y [rad], each (N,).
    """
    smooth = cv2.GaussianBlur(scene.heights, (0, 0), _SMOOTHING)
    slope_x = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, ksize=1, scale=0.5 / scene.cell)
    slope_y = cv2.Sobel(smooth, cv2.CV_32F, 0, 1, ksize=1, scale=0.5 / scene.cell)
    slope = np.hypot(slope_x, slope_y)
    row, column = np.nonzero((slope > _STEEP) & (scene.heights > floor + _LOWEST))
    # The same ones in the same image.
    chosen = np.random.default_rng(len(row)).choice(len(row), min(COUNT, len(row)), replace=False)
    row, column = row[chosen], column[chosen]
    inward = np.stack([slope_x[row, column], slope_y[row, column]], 1) / slope[row, column, None]
    start = scene.origin + scene.cell * np.stack([column, row], axis=1) + _INWARD * inward
    surface = scene.at(start[:, 0], start[:, 1])
    way = np.arange(0.0, gripper.opening, _STEP)
    line = start[:, None] + inward[:, None] * way[None, :, None]
    least = np.maximum(0.5 * (surface + floor), surface - _FALL)
    ended = scene.at(line[..., 0], line[..., 1]) < least[:, None]
    end = np.where(ended.any(axis=1), ended.argmax(axis=1), 0)
    found = end >= _NARROWEST
    middle = start + inward * (0.5 * (way[end] - _INWARD))[:, None]
    direction = np.arctan2(inward[:, 1], inward[:, 0])
    return middle[found, 0], middle[found, 1], direction[found]
