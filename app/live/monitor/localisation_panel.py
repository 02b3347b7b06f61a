"""Where the base is and believes to be: true base, outline, laser scan, what is matched and moved.

Only where its pose on the map is an estimate.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np
import rerun as rr

from app.live.feed import Throttle
from app.live.monitor.columns import WORLD, Changes, log_static, send_poses
from app.live.monitor.glyphs import Colour, printable
from app.live.monitor.robot_visual import solids
from app.live.robot_parts import base_parts
from app.live.run_snapshot import PoseEstimate, SceneView, Snapshot
from config.arrays import Array
from config.planar import rotate
from robots import Geom, Plane, RobotDescription, reach

Made = TypeVar("Made")

_PERIOD = 0.1  # shortest time between two drawings [s]
_TRUE: Colour = (235, 120, 235)
_BELIEVED: Colour = (255, 255, 255)
_SCANNED: Colour = (255, 220, 60)
_MATCHED: Colour = (60, 220, 100)
_MOVED: Colour = (255, 120, 30)
_UP = np.array([0.0, 0.0, 1.0])
_SIDES, _FLOOR = 48, 0.012  # of the outline, and its height above the floor [m]

_ROOM = "world/localisation"
TRUE_BASE, OUTLINE = f"{_ROOM}/true_base", f"{_ROOM}/outline"
SCAN, MATCHED, DISPLACED = f"{_ROOM}/scan", f"{_ROOM}/matched", f"{_ROOM}/displaced"


class LocalisationPanel:
    """Draws the estimate of the pose, and what it rests on, on the map."""

    def __init__(
        self, stream: rr.RecordingStream, robot: RobotDescription, scene: SceneView
    ) -> None:
        self._stream = stream
        self._throttle = Throttle(_PERIOD)
        self._changes = Changes(stream)
        self._size = robot.base.size[:2]
        self._tops = _tops(scene.fixtures)
        ghost = solids(base_parts(robot.base)[:1], "TransparentFillMajorWireframe")
        for body in ghost:
            body.colors = [(*_TRUE, 90)]
        log_static(stream, {TRUE_BASE: ghost})
        outline = rr.LineStrips3D.from_fields(
            colors=[_BELIEVED], radii=rr.Radius.ui_points(1.5), show_labels=True
        )
        displaced = rr.Arrows3D.from_fields(colors=[_MOVED], radii=0.015, show_labels=True)
        looks: dict[str, list[Any]] = {
            OUTLINE: [outline],
            SCAN: [_points(_SCANNED)],
            MATCHED: [_points(_MATCHED)],
            DISPLACED: [displaced],
        }
        log_static(stream, looks, WORLD)

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the snapshots of a batch."""
        shown = [s for s in batch if s.estimate is not None and self._throttle.due(s.stamp)]
        true = [(s, s.estimate.true_base) for s in shown if s.estimate is not None]
        send_poses(self._stream, [(s, {TRUE_BASE: oTb}) for s, oTb in true if oTb is not None])
        send = self._changes.send
        outline = partial(_outline, self._size)
        found = _of(lambda e: (e.registration,))
        send(OUTLINE, rr.LineStrips3D, shown, _of(lambda e: (e.covariance,)), _of(outline))
        send(SCAN, rr.Points3D, shown, _of(lambda e: (e.scan,)), _of(_scan))
        send(MATCHED, rr.Points3D, shown, found, _of(_matched))
        send(DISPLACED, rr.Arrows3D, shown, found, _of(self._displaced))

    def _displaced(self, estimate: PoseEstimate) -> dict[str, Any]:
        """Arrows on top of furniture, from where the map has it to where it was found."""
        moved = () if estimate.registration is None else estimate.registration.displaced
        return {
            "origins": [(*one.centre, self._tops.get(one.piece, 0.0)) for one in moved],
            "vectors": [(*one.by[:2], 0.0) for one in moved],
            "labels": [
                f"{printable(one.piece)} moved by {1000.0 * np.hypot(*one.by[:2]):.0f} mm, "
                f"{np.rad2deg(one.by[2]):.1f}°"
                for one in moved
            ],
        }


def _of(of: Callable[[PoseEstimate], Made]) -> Callable[[Snapshot], Made]:
    """The same of a snapshot that has an estimate."""

    def made(snapshot: Snapshot) -> Made:
        assert snapshot.estimate is not None
        return of(snapshot.estimate)

    return made


def _points(colour: Colour) -> rr.Points3D:
    return rr.Points3D.from_fields(colors=[colour], radii=0.012)


def _tops(fixtures: Sequence[Geom]) -> dict[str, float]:
    """Height of each piece of furniture [m]."""
    tops: dict[str, float] = {}
    for one in fixtures:
        if not isinstance(one.shape, Plane):
            piece = one.name.split("/")[0]
            tops[piece] = max(tops.get(piece, 0.0), reach(one, _UP))
    return tops


def _outline(size: tuple[float, float], estimate: PoseEstimate) -> dict[str, Any]:
    """The convex hull of the ellipses in which the corners of the base lie, `size` [m] apart."""
    x, y, heading = estimate.mTb
    signs = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
    corners = np.column_stack(rotate(heading, *(signs * size / 2.0).T))
    J = np.tile(np.eye(2, 3), (4, 1, 1))
    J[:, 0, 2], J[:, 1, 2] = -corners[:, 1], corners[:, 0]
    covariances = J @ estimate.covariance @ J.transpose(0, 2, 1)
    angles = np.linspace(0.0, 2.0 * np.pi, _SIDES + 1)
    towards = np.column_stack([np.cos(angles), np.sin(angles)])
    spread = np.sqrt(np.einsum("ni,kij,nj->nk", towards, covariances, towards))
    best = (towards @ corners.T + 2.0 * spread).argmax(axis=1)
    rows = np.arange(len(towards))
    grown = np.einsum("nij,nj->ni", covariances[best], towards) / spread[rows, best][:, None]
    points = np.array([x, y]) + corners[best] + 2.0 * grown
    strip = np.column_stack([points, np.full(len(points), _FLOOR)])
    return {"strips": [strip], "labels": [f"±{1000.0 * estimate.two_sigma[0]:.0f} mm"]}


def _scan(estimate: PoseEstimate) -> dict[str, Any]:
    points: Array = np.zeros((0, 3))
    if (scan := estimate.scan) is not None:
        mTb = estimate.mTo * scan.oTb
        points = scan.points[np.isfinite(scan.ranges)] @ mTb.rotation.T + mTb.translation
    return {"positions": points}


def _matched(estimate: PoseEstimate) -> dict[str, Any]:
    found = estimate.registration
    return {"positions": np.zeros((0, 3)) if found is None else found.points}
