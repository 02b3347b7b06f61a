"""Live access to a run: recording and viewer, status line, and control by a person.

Every tick becomes one `Snapshot`. `monitor` records it and serves it to the viewer, `operator`
pauses, steps and stops the run by keys, page and hooks, `groot` speaks to Groot2, and
`OperatorConsole` puts together the controls that the user asked for. Nothing here runs the loop;
the core passes snapshots in and asks `Control`.
"""

from app.live.console import ControlOptions, OperatorConsole
from app.live.feed import Feed
from app.live.monitor import (
    Address,
    AnyRecorder,
    HeadlessViewer,
    NoRecorder,
    Recorder,
    RecorderError,
    View,
    Viewer,
    ViewError,
    ViewOptions,
    headless_viewer,
    open_in_viewer,
)
from app.live.nodes import NodeStatus, tip, tree_view
from app.live.operator import Control, Hook, WebViewer
from app.live.snapshot import ObjectView, SceneView, Signals, Snapshot, key_figures
from app.live.status_line import StatusLine
from app.live.throttle import Throttle

__all__ = [
    "Address",
    "AnyRecorder",
    "Control",
    "ControlOptions",
    "Feed",
    "HeadlessViewer",
    "Hook",
    "NoRecorder",
    "NodeStatus",
    "ObjectView",
    "OperatorConsole",
    "Recorder",
    "RecorderError",
    "SceneView",
    "Signals",
    "Snapshot",
    "StatusLine",
    "Throttle",
    "View",
    "ViewError",
    "ViewOptions",
    "Viewer",
    "WebViewer",
    "headless_viewer",
    "key_figures",
    "open_in_viewer",
    "tip",
    "tree_view",
]
