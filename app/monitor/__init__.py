"""What a run tells: one `Snapshot` a tick, kept as a Rerun recording that shows the whole of it.

The tree, the robot in its scene, what the camera saw and how the controller fared lie on one
timeline. `Recorder` is handed the snapshots; Rerun is imported when the first one is made.
"""

from app.monitor.recorder import Recorder, RecorderError
from app.monitor.snapshot import NodeInfo, NodeStatus, ObjectView, SceneView, Signals, Snapshot

__all__ = [
    "NodeInfo",
    "NodeStatus",
    "ObjectView",
    "Recorder",
    "RecorderError",
    "SceneView",
    "Signals",
    "Snapshot",
]
