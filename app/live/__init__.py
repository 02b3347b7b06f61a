"""Live access to a run: recording and viewer, the tree in the terminal, and control by people.

Every tick becomes a `Snapshot`. `monitor` records it and serves it to the viewer; `operator`
pauses, steps and stops the run by keys, page and hooks; `groot` serves Groot2; `OperatorConsole`
combines the controls of a run. The core passes snapshots in and asks `Control`.
"""

from app.choices import View
from app.live.changes import Changes, LogLine, Moment, Noted, RunInfo
from app.live.console import ControlOptions, OperatorConsole
from app.live.feed import Feed, Throttle
from app.live.monitor import Recorder, RecorderError, draw_robot
from app.live.nodes import NodeInfo, NodeStatus, looks, tip, tree_view
from app.live.operator import Control, Document, Hook, PageServer, RunProcess, Told
from app.live.picture import colour_png, depth_picture, depth_png
from app.live.plan import STYLE, Plan, line
from app.live.run_display import RunDisplay
from app.live.snapshot import PoseEstimate, SceneView, ShownRun, Snapshot, key_figures
from app.live.viewer.headless import headless_viewer
from app.live.viewer.viewer import Viewer, ViewError, ViewOptions, check_recording, open_in_viewer
from app.live.web.ports import Address
