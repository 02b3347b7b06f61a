"""Eye of the 3-D view: placed so that the whole task is visible."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import radians, tan

import numpy as np

from app.live.snapshot import Array, SceneView
from robots import Plane, half_extents

FIELD = radians(55.0)
"""Vertical field of view of Rerun's eye [rad]."""
_FROM = np.array([-0.26, -0.72, 0.62])
_ASPECT = 1.5
_MARGIN = 0.94
_HEIGHT = 1.2
"""Height of a robot with its arm at work [m]."""
_AROUND = 0.85
"""Radius of a robot that works at a goal [m]."""
_SLIM = 0.6
_STEPS = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class Eye:
    """A camera that looks from one point at another, with z up."""

    position: Array
    target: Array

    def project(self, points: Array, width: float, height: float) -> Array:
        """Pixels (N, 2) of points (N, 3) in the world; NaN behind the eye."""
        local = (points - self.position) @ _axes(self.position - self.target).T
        depth = np.where(local[:, 2] > 1e-6, local[:, 2], np.nan)
        scale = height / 2.0 / tan(FIELD / 2.0) / depth
        pixels: Array = np.stack(
            [width / 2.0 + local[:, 0] * scale, height / 2.0 - local[:, 1] * scale], axis=1
        )
        return pixels

    def sees(self, points: Array) -> bool:
        """Whether all points (N, 3) are in the narrowest picture."""
        pixels = self.project(points, _ASPECT, 1.0)
        return bool(((pixels > 0.0) & (pixels < [_ASPECT, 1.0])).all())


def eye_for(points: Array) -> Eye:
    """The nearest eye that sees all points (N, 3) in the world [m]; at least one point."""
    right, up, ahead = axes = _axes(_FROM)
    limits = np.array([_ASPECT, 1.0]) * tan(FIELD / 2.0) * _MARGIN
    target: Array = (points.min(axis=0) + points.max(axis=0)) / 2.0
    for _ in range(_STEPS):
        local = (points - target) @ axes.T
        distance = max(1.0, float((np.abs(local[:, :2]) / limits - local[:, 2:]).max()))
        eye = Eye(position=target - distance * ahead, target=target)
        seen = local[:, :2] / (local[:, 2:] + distance)
        off = (seen.min(axis=0) + seen.max(axis=0)) / 2.0 * distance
        target = target + off[0] * right + off[1] * up
    return eye


def task_points(scene: SceneView) -> Array:
    """(N, 3) corners of furniture and regions, and of the robot at its start and goals."""
    boxes = [(region.pose, region.size / 2.0) for region in scene.regions]
    for part in scene.fixtures:
        if not isinstance(part.shape, Plane):
            boxes.append((part.pose, np.array(half_extents(part.shape))))
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    found = [robot_points(0.0, 0.0)]
    for pose, half in boxes:
        found.append((corners * half) @ pose.rotation.T + pose.translation)
    for _, pose in scene.goals:
        x, y, z = pose.translation
        found.append(robot_points(x, y, _AROUND, max(_HEIGHT, z + 0.3)))
    return np.concatenate(found)


def robot_points(x: float, y: float, around: float = 0.45, height: float = _HEIGHT) -> Array:
    """(16, 3) points around a robot at a place on the floor [m]."""
    angles = np.arange(8) * np.pi / 4.0
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(8)])
    low, high = around * circle, _SLIM * around * circle + [0.0, 0.0, height]
    points: Array = np.concatenate([low, high]) + np.array([x, y, 0.0])
    return points


def _axes(back: Array) -> Array:
    """(3, 3) right, up and ahead of an eye that looks against `back`, as rows."""
    ahead = -back / np.linalg.norm(back)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, ahead), ahead])
