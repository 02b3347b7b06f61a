"""Live access to a run: recording and viewer, status line, and control by a person.

Every tick becomes one `Snapshot`. `monitor` records it and serves it to the viewer, `operator`
pauses, steps and stops the run by keys, page and hooks, `groot` speaks to Groot2, and
`OperatorConsole` puts together the controls that the user asked for. Nothing here runs the loop;
the core passes snapshots in and asks `Control`.
"""

from app.live.console import ControlOptions, NoControlError, OperatorConsole
from app.live.groot import GrootError
from app.live.monitor import (
    LOOPBACK,
    USUAL_WEB_PORT,
    Address,
    HeadlessViewer,
    Recorder,
    RecorderError,
    View,
    Viewer,
    ViewError,
    ViewOptions,
    choose_port,
    has_screen,
    has_vulkan,
    headless_viewer,
    viewer_program,
)
from app.live.nodes import NodeInfo, NodeStatus, tip, tree_view
from app.live.operator import Control, ControlState, Hook, PageError, UnknownNodeError, WebViewer
from app.live.snapshot import ObjectView, SceneView, Signals, Snapshot, key_figures
from app.live.status_line import StatusLine
from app.live.throttle import Throttle

__all__ = [
    "LOOPBACK",
    "USUAL_WEB_PORT",
    "Address",
    "Control",
    "ControlOptions",
    "ControlState",
    "GrootError",
    "HeadlessViewer",
    "Hook",
    "NoControlError",
    "NodeInfo",
    "NodeStatus",
    "ObjectView",
    "OperatorConsole",
    "PageError",
    "Recorder",
    "RecorderError",
    "SceneView",
    "Signals",
    "Snapshot",
    "StatusLine",
    "Throttle",
    "UnknownNodeError",
    "View",
    "ViewError",
    "ViewOptions",
    "Viewer",
    "WebViewer",
    "choose_port",
    "has_screen",
    "has_vulkan",
    "headless_viewer",
    "key_figures",
    "tip",
    "tree_view",
    "viewer_program",
]
