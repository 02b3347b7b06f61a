"""Layout of the viewer: tree on the left, history in the middle, scene and camera on the right."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint import archetypes, encodings

from app.live.monitor.framing import Eye
from app.live.monitor.signals_panel import PLOTS, SHARES
from app.live.monitor.tree_panel import PILL_RADIUS, ROW, pills
from app.live.nodes import NodeInfo

_PLOT_WINDOW, _HISTORY_WINDOW, _TRAIL_WINDOW = 20.0, 30.0, 8.0
"""Shown before the cursor [s]."""
_FEWEST_ROWS, _MOST_ROWS = 22, 40
"""Of the tree."""
_TABS = {
    "velocities": (SHARES, "base_velocity", "base_rotation"),
    "goal": ("distance", "angle"),
    "controller": ("clearance", "manipulability", "slack"),
    "loop": ("tick",),
}
_CLOUD_RANGE = (150.0, 1500.0)
"""Depths at both ends of the colour map [mm]."""
_BACKGROUND = (24, 26, 31)


class Arrangement(rrb.Blueprint):
    """A layout whose own stream can be ended, which Rerun never does."""

    def _log_to_stream(self, stream: rr.RecordingStream) -> None:
        self._stream = stream
        super()._log_to_stream(stream)

    def release(self) -> None:
        """End the stream of the layout, once it has been sent."""
        self._stream.disconnect()
        del self._stream


def blueprint(tree: Sequence[NodeInfo], eye: Eye, *, live: bool) -> Arrangement:
    """The layout for a tree, seen by `eye`; in a `live` run the cursor follows the newest data."""
    now = rrb.TextDocumentView(origin="/now", name="now")
    history = rrb.StateTimelineView(
        origin="/status", name="history", time_view=_last(_HISTORY_WINDOW)
    )
    signals = rrb.Tabs(
        *(rrb.Vertical(*map(_plot, entities), name=name) for name, entities in _TABS.items()),
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


def _plot(entity: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=f"/signals/{entity}",
        name=PLOTS[entity].name,
        axis_x=_last(_PLOT_WINDOW),
        axis_y=rrb.ScalarAxis(range=(-1.05, 1.05)) if entity == SHARES else None,
        plot_legend=rrb.PlotLegend(
            corner=rrb.Corner2D.LeftTop, visible=len(PLOTS[entity].series) > 1
        ),
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
    relative = rrb.TimeRangeBoundary.cursor_relative
    trail = rrb.VisibleTimeRanges(
        timeline="t", start=relative(seconds=-_TRAIL_WINDOW), end=relative()
    )
    return rrb.Spatial3DView(
        origin="/world",
        name="scene",
        contents=["+ $origin/**", "- /world/camera/quality", "- /world/camera/grasps"],
        overrides={
            "world/trail": trail,
            "world/base_trail": trail,
            "world/camera/depth": rr.EncodedDepthImage.from_fields(
                colormap="viridis", point_fill_ratio=0.6, depth_range=_CLOUD_RANGE
            ),
        },
        background=_BACKGROUND,
        line_grid=rrb.LineGrid3D(visible=True, spacing=0.5, color=(70, 74, 82)),
        eye_controls=rrb.EyeControls3D(position=eye.position, look_target=eye.target),
    )
