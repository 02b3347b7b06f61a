"""Live access to a run: recording and viewer, the tree in the terminal, and control by people.

Every tick becomes a `Snapshot`. `monitor` records it and serves it to the viewer; `Control`
and hooks pause, step and stop the run; `OperatorConsole` combines the controls of a run;
`observers` are what packages offer, as the control page. The core passes snapshots in and asks
`Control`.
"""

from app.choices import View
from app.live.changes import Changes, LogLine, Noted, RunInfo
from app.live.control import Control
from app.live.feed import Feed, Throttle
from app.live.hooks import Hook
from app.live.monitor import Recorder, RecorderError, draw_robot
from app.live.nodes import (
    STATUS_GLYPH,
    Look,
    NodeInfo,
    NodeStatus,
    looks,
    parents,
    path_from_root,
    tip,
    tree_view,
)
from app.live.observers import LiveRun, Observer, observers
from app.live.operator_console import OperatorConsole
from app.live.picture import colour_png, depth_png, grasp_outline, grey_range, millimetres
from app.live.robot_parts import arm_parts, base_parts, finger_poses, hand_parts
from app.live.run_display import RunDisplay
from app.live.run_snapshot import PoseEstimate, SceneView, ShownRun, Snapshot, key_figures
from app.live.viewer.viewer import Viewer, ViewError, check_recording, open_in_viewer
