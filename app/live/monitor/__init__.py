"""Recording a run and showing it in the Rerun viewer.

Tree, robot, scene, camera and controller lie on one timeline. `Recorder` takes one `Snapshot` a
tick, writes the recording and serves it; `Viewer` starts the viewer that connects to it. Rerun
itself is imported when the first recorder is made.
"""

from app.live.monitor.headless import HeadlessViewer, has_vulkan, headless_viewer
from app.live.monitor.ports import LOOPBACK, Address, choose_port
from app.live.monitor.recorder import Recorder, RecorderError
from app.live.monitor.viewer import (
    USUAL_WEB_PORT,
    View,
    Viewer,
    ViewError,
    ViewOptions,
    has_screen,
    viewer_program,
)

__all__ = [
    "LOOPBACK",
    "USUAL_WEB_PORT",
    "Address",
    "HeadlessViewer",
    "Recorder",
    "RecorderError",
    "View",
    "ViewError",
    "ViewOptions",
    "Viewer",
    "choose_port",
    "has_screen",
    "has_vulkan",
    "headless_viewer",
    "viewer_program",
]
