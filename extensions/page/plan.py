"""Plan of a run as SVG, seen from above: furniture, regions and goals, and what moves.

x points right and y up, in centimetres; the colours are those of `plan.css`. The page draws it
again a few times a second, and an explanation once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path

import cv2
import numpy as np
from pinocchio import SE3

from app.live import SceneView, Snapshot
from config.arrays import Array
from config.poses import MapPose
from controller import se3_of
from robots import CORNERS, Cylinder, Geom, Hull, Plane, Sphere, half_extents

STYLE = Path(__file__).parent / "static" / "plan.css"
_MARGIN = 55.0  # around what is drawn [cm]
_LEAST_UNCERTAINTY = 0.02  # drawn as a circle from here on [m]


class Plan:
    """Draws a scene and a robot whose base has a size along x and y [m]."""

    def __init__(self, scene: SceneView, size: Sequence[float]) -> None:
        self._objects = [(name, _radius(parts)) for name, parts in scene.objects]
        self._size = size
        solid = [part for part in scene.fixtures if not isinstance(part.shape, Plane)]
        outlines = {part: _outline(part) for part in solid}
        regions = [_corners(region.mTr, region.size[:2] / 2.0) for region in scene.regions]
        goals = [pose.translation[:2] for _, pose in scene.goals]
        self._extent = [*outlines.values(), *regions, *([np.array(goals)] if goals else [])]
        pieces: dict[str, list[Array]] = {}
        for part in sorted(solid, key=_top, reverse=True):
            pieces.setdefault(part.piece, []).append(outlines[part])
        span = np.ptp(np.concatenate(self._extent), axis=0).max() if self._extent else 0.0
        self.fixed = "".join(
            [
                *(_polygon("furniture", outlines[one]) for one in sorted(solid, key=_top)),
                *(_polygon("region", one) for one in regions),
                *(_circle("goal", at, 0.04) for at in goals),
                *_names(pieces, max(0.12, float(span) / 28.0)),
            ]
        )
        """What does not move."""

    def now(self, seen: Snapshot) -> str:
        """What moves in a tick."""
        base, hand = seen.mTb, seen.mTe
        parts = [
            _circle("object", pose.translation[:2], radius)
            for (_, radius), pose in zip(self._objects, seen.objects, strict=False)
        ]
        if seen.way is not None:
            parts.append(line("way", seen.way[:, :2]))
        if seen.base_goal is not None:
            parts.append(_polygon("aim", _corners(se3_of(seen.base_goal), self._half)))
        if seen.estimate is not None and (two := seen.estimate.two_sigma[0]) > _LEAST_UNCERTAINTY:
            parts.append(_circle("doubt", base.translation[:2], two))
        parts.append(self.robot(base, "robot fault" if seen.state.faults else "robot"))
        parts.append(line("arm", np.array([base.translation[:2], hand.translation[:2]])))
        if seen.hand_goal is not None:
            parts.append(_circle("aim", seen.hand_goal.translation[:2], 0.05))
        parts.append(_circle("hand held" if seen.holds else "hand", hand.translation[:2], 0.06))
        return "".join(parts)

    def robot(self, mTb: MapPose, look: str = "robot") -> str:
        """The outline of the base, with a mark at its front."""
        nose = np.array([[0.6, 0.3], [0.9, 0.0], [0.6, -0.3]]) * self._half
        front = nose @ mTb.rotation[:2, :2].T + mTb.translation[:2]
        return _polygon(look, _corners(mTb, self._half)) + _polygon("nose", front)

    def view_box(self, *more: Array) -> str:
        """The part of the plan that shows all of it, and more points (N, 2) [m]."""
        points = [*self._extent, *more]
        both = 100.0 * np.concatenate([*points])
        low, high = both.min(axis=0) - _MARGIN, both.max(axis=0) + _MARGIN
        return f"{low[0]:.0f} {-high[1]:.0f} {high[0] - low[0]:.0f} {high[1] - low[1]:.0f}"

    @property
    def _half(self) -> Array:
        return np.array(self._size[:2]) / 2.0


def line(look: str, points: Array) -> str:
    """A line through (N, 2) points [m]."""
    return f'<polyline class="{look}" points="{_points(points)}"/>'


def _polygon(look: str, points: Array) -> str:
    return f'<polygon class="{look}" points="{_points(points)}"/>'


def _circle(look: str, at: Array, radius: float) -> str:
    x, y = 100.0 * at
    return f'<circle class="{look}" cx="{x:.0f}" cy="{-y:.0f}" r="{max(100.0 * radius, 2.0):.0f}"/>'


def _points(points: Array) -> str:
    return " ".join(f"{x},{-y}" for x, y in np.rint(100.0 * points).astype(int).tolist())


def _corners(pose: SE3, half: Array) -> Array:
    """(4, 2) corners of an upright box."""
    around = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * half
    corners: Array = around @ pose.rotation[:2, :2].T + pose.translation[:2]
    return corners


def _outline(part: Geom) -> Array:
    """(N, 2) convex outline of a shape from above."""
    shape = part.shape
    points = shape.vertices if isinstance(shape, Hull) else CORNERS * half_extents(shape)
    if isinstance(shape, Sphere | Cylinder):
        turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        ring = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
        points = half_extents(shape)[0] * ring
    flat = (points @ part.pose.rotation.T + part.pose.translation)[:, :2]
    hull: Array = cv2.convexHull(flat.astype(np.float32))[:, 0].astype(float)
    return hull


def _names(pieces: Mapping[str, Sequence[Array]], size: float) -> Iterator[str]:
    """The names of pieces of furniture, the highest first, below each; what it hides has none."""
    named: list[Array] = []
    for name, outlines in pieces.items():
        both = np.concatenate([*outlines])
        low, high = both.min(axis=0), both.max(axis=0)
        below = np.array([(low[0] + high[0]) / 2.0, low[1] - size])
        if name and all(np.hypot(*(below - other)) > 1.6 * size for other in named):
            named.append(below)
            x, y = 100.0 * below
            at = f'x="{x:.0f}" y="{-y:.0f}" font-size="{100.0 * size:.0f}"'
            yield f'<text class="name" {at}>{escape(name)}</text>'


def _top(part: Geom) -> float:
    return float(part.pose.translation[2] + half_extents(part.shape)[2])


def _radius(parts: Sequence[Geom]) -> float:
    return max((min(half_extents(part.shape)[:2]) for part in parts), default=0.03)
