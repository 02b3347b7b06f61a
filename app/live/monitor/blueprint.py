"""Layout of the viewer: tree on the left, history in the middle, scene and camera on the right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import radians, tan

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint import archetypes, encodings

from app.live.monitor.signals_panel import SHARES, Curves
from app.live.monitor.tree_panel import PILL_RADIUS, ROW, pills
from app.live.nodes import NodeInfo
from app.live.run_snapshot import Array, SceneView
from robots import CORNERS, Plane, half_extents

_PLOT_WINDOW, _HISTORY_WINDOW = 20.0, 30.0  # shown before the cursor [s]
_FEWEST_ROWS, _MOST_ROWS = 22, 40  # of the tree
_TABS = {
    "velocities": (SHARES, "base_velocity", "base_rotation"),
    "goal": ("distance", "angle"),
    "controller": ("clearance", "manipulability", "slack"),
    "loop": ("tick",),
    "localisation": ("pose_position", "pose_heading"),
}
_CLOUD_RANGE = (150.0, 1500.0)  # depths at both ends of the colour map [mm]
_BACKGROUND = (24, 26, 31)

FIELD = radians(55.0)  # vertical field of view of Rerun's eye [rad]
_FROM = np.array([-0.26, -0.72, 0.62])
_ASPECT = 1.5
_MARGIN = 0.94
_HEIGHT = 1.2  # height of a robot with its arm at work [m]
_AROUND = 0.85  # radius of a robot that works at a goal [m]
_SLIM = 0.6
_STEPS = 8


class Arrangement(rrb.Blueprint):
    """A layout whose own stream can be ended, which Rerun never does."""

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        super()._log_to_stream(stream)

    def release(self) -> None:
        """End the stream of the layout, once it has been sent."""
        self._stream.disconnect()
        del self._stream


def blueprint(
    tree: Sequence[NodeInfo], eye: Eye, plots: Mapping[str, Curves], *, live: bool
) -> Arrangement:
    """The layout for a tree, seen by `eye`; in a `live` run the cursor follows the newest data."""
    now = rrb.TextDocumentView(origin="/now", name="now")
    history = rrb.StateTimelineView(
        origin="/status", name="history", time_view=_last(_HISTORY_WINDOW)
    )
    signals = rrb.Tabs(
        *(
            rrb.Vertical(*(_plot(entity, plots[entity]) for entity in entities), name=name)
            for name, entities in _TABS.items()
            if plots.keys() >= set(entities)
        ),
        active_tab=0,
    )
    camera = rrb.Spatial2DView(
        origin="/world/camera", name="depth and grasp quality", background=_BACKGROUND
    )
    return Arrangement(
        rrb.Horizontal(
            rrb.Vertical(_tree(tree), now, row_shares=[5, 1]),
            rrb.Vertical(history, _log(), row_shares=[2, 1]),
            rrb.Vertical(
                _scene(eye),
                rrb.Horizontal(camera, signals, column_shares=[1, 1.3]),
                row_shares=[1.5, 1],
            ),
            column_shares=[1, 1, 1.9],
        ),
        rrb.TimePanel(
            state="collapsed", timeline="t", play_state="following" if live else "playing"
        ),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
    )


def _last(seconds: float) -> archetypes.TimeAxis:
    """The seconds before the cursor, and a tenth of that after it."""
    relative = rrb.TimeRangeBoundary.cursor_relative
    window = rr.TimeRange(start=relative(seconds=-seconds), end=relative(seconds=seconds / 10))
    return archetypes.TimeAxis(view_range=window)


def _plot(entity: str, curves: Curves) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=f"/signals/{entity}",
        name=curves.name,
        axis_x=_last(_PLOT_WINDOW),
        axis_y=rrb.ScalarAxis(range=(-1.05, 1.05)) if entity == SHARES else None,
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.LeftTop, visible=len(curves.series) > 1),
    )


def _tree(tree: Sequence[NodeInfo]) -> rrb.Spatial2DView:
    right = float(pills(tree)[:, 1, 0].max()) + PILL_RADIUS + ROW / 2
    rows = float(np.clip(len(tree), _FEWEST_ROWS, _MOST_ROWS))
    bounds = rrb.VisualBounds2D(x_range=(-ROW, right), y_range=(-ROW, ROW * rows))
    return rrb.Spatial2DView(
        origin="/tree/list", name="tree", visual_bounds=bounds, background=_BACKGROUND
    )


def _log() -> rrb.TextLogView:
    """The log without the viewer's own columns, which are too narrow to read."""
    columns = archetypes.TextLogColumns(
        timeline_columns=[encodings.TimelineColumn(name, visible=False) for name in ("t", "tick")],
        text_log_columns=[encodings.TextLogColumn(encodings.TextLogColumnKind.Body)],
    )
    return rrb.TextLogView(origin="/log", name="log", columns=columns)


def _scene(eye: Eye) -> rrb.Spatial3DView:
    return rrb.Spatial3DView(
        origin="/world",
        name="scene",
        contents=["+ $origin/**", "- /world/camera/quality", "- /world/camera/grasps"],
        overrides={
            "world/camera/depth": rr.EncodedDepthImage.from_fields(
                colormap="viridis", point_fill_ratio=0.6, depth_range=_CLOUD_RANGE
            )
        },
        background=_BACKGROUND,
        line_grid=rrb.LineGrid3D(visible=True, spacing=0.5, color=(70, 74, 82)),
        eye_controls=rrb.EyeControls3D(position=eye.position, look_target=eye.target),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Eye:
    """A camera that looks from one point at another, with z up."""

    position: Array
    target: Array


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
    boxes = [(region.mTr, region.size / 2.0) for region in scene.regions]
    for part in scene.fixtures:
        if not isinstance(part.shape, Plane):
            boxes.append((part.pose, np.array(half_extents(part.shape))))
    found = [robot_points(0.0, 0.0)]
    for pose, half in boxes:
        found.append((CORNERS * half) @ pose.rotation.T + pose.translation)
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
