"""Rerun stream to file and viewers, and the panels that write to it.

The server for viewers runs in this process and drops the oldest data when its memory is full, so
writing never waits for a viewer, as a sink that connects to one would.
"""

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import rerun as rr
import rerun_bindings

from app.live.monitor.blueprint import blueprint, eye_for, task_points
from app.live.monitor.camera_panel import CameraPanel
from app.live.monitor.localisation_panel import LocalisationPanel
from app.live.monitor.scene_panel import ScenePanel
from app.live.monitor.signals_panel import PLOTS, POSE_PLOTS, SignalsPanel
from app.live.monitor.text_panel import TextPanel
from app.live.monitor.tree_panel import TreePanel
from app.live.nodes import NodeInfo
from app.live.run_snapshot import SceneView, Snapshot
from app.web import Address
from controller import RobotModel

_SERVER_MEMORY = "200MB"  # data for viewers that connect late: more than ten minutes
_LINGER = 1.0  # time for viewers to fetch the end of a run [s]


class Panel(Protocol):
    """A part of the picture."""

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the snapshots of a batch."""


class Writer:
    """Writes batches of snapshots; used by one thread at a time.

    Raises OSError, RuntimeError: the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        *,
        tree: Sequence[NodeInfo],
        model: RobotModel,
        scene: SceneView,
        server: Address | None,
    ) -> None:
        rr.set_strict_mode(True)  # mistakes are raised, not turned into a warning on the terminal
        self._live = server is not None
        self._stream = rr.RecordingStream("frankie-task")
        plots = PLOTS | POSE_PLOTS if scene.estimated else PLOTS
        layout = blueprint(tree, eye_for(task_points(scene)), plots, live=self._live)
        self._stream.set_sinks(
            # A footer would keep something of every chunk in memory until the end.
            rr.FileSink(path, write_footer=False),
            *([] if server is None else [_served(server)]),
            default_blueprint=layout,
        )
        layout.release()
        self._panels: list[Panel] = [
            TreePanel(self._stream, tree),
            TextPanel(self._stream, tree),
            ScenePanel(self._stream, model, scene),
            CameraPanel(self._stream, model.description.camera.intrinsics),
            SignalsPanel(self._stream, model.description, plots),
        ]
        if scene.estimated:
            self._panels.append(LocalisationPanel(self._stream, model.description, scene))

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add snapshots, in order of time; at least one."""
        for panel in self._panels:
            panel.write(batch)

    def close(self) -> None:
        """Flush and close the file, stop serving viewers, and end the stream's threads."""
        try:
            self._stream.flush()
            if self._live:
                threading.Event().wait(_LINGER)
        finally:
            self._stream.disconnect()
            # A stream that nobody holds any more still has its threads, until it is cleaned up.
            del self._stream, self._panels
            rerun_bindings.flush_and_cleanup_orphaned_recordings()


def _served(server: Address) -> rr.GrpcServerSink:
    return rr.GrpcServerSink(
        bind_ip=server.host, port=server.port, server_memory_limit=_SERVER_MEMORY
    )
