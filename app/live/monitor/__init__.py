"""What a run tells: one `Snapshot` a tick, shown live in Rerun and kept as a recording.

The tree, the robot in its scene, what the camera saw and how the controller fared lie on one
timeline. `Recorder` is handed the snapshots, writes them and serves them; Rerun is imported when
the first one is made. `Viewer` starts what a person watches with.
"""

from app.live.monitor.recorder import Recorder, RecorderError
from app.live.monitor.snapshot import NodeInfo, NodeStatus, ObjectView, SceneView, Signals, Snapshot
from app.live.monitor.viewer import View, Viewer, ViewError, ViewOptions

__all__ = [
    "NodeInfo",
    "NodeStatus",
    "ObjectView",
    "Recorder",
    "RecorderError",
    "SceneView",
    "Signals",
    "Snapshot",
    "View",
    "ViewError",
    "ViewOptions",
    "Viewer",
]
