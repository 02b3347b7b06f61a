"""Where it goes: a Rerun stream to the file and to viewers, and the panels that fill it.

The server for viewers lives in this process and forgets the oldest data when its memory is full, so
that writing never waits for a viewer. (A sink that connects to a viewer would: it blocks for good
once a viewer hangs.)
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Sequence
from pathlib import Path

import rerun as rr

from app.live.monitor.blueprint import blueprint
from app.live.monitor.camera_panel import CameraPanel
from app.live.monitor.scene_panel import ScenePanel
from app.live.monitor.signals_panel import SignalsPanel
from app.live.monitor.snapshot import NodeInfo, SceneView, Snapshot
from app.live.monitor.tree_panel import TreePanel
from app.live.monitor.viewer import Address, ViewError
from app.live.monitor.words_panel import WordsPanel
from controller import RobotModel

APPLICATION = "frankie-task"
"""The viewer keeps a person's changes of the layout under this name."""

_SERVER_MEMORY = "200MB"
"""What viewers that come late can still be shown: more than ten minutes."""

_PATIENCE = 5.0
_FAREWELL = 1.0
"""Viewers are given so long to fetch the end of a run [s]."""


class Writer:
    """Writes batches of snapshots; to be used by one thread at a time.

    Args:
        path: the file to write.
        tree: the nodes of the tree, in preorder.
        model: kinematics of the robot; the writer's alone.
        scene: what the world looks like.
        server: where viewers are served too; None for nowhere.

    Raises:
        OSError, RuntimeError: the file cannot be written.
        ViewError: nothing can be served there.
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
        self._stream = rr.RecordingStream(APPLICATION)
        self._stream.set_sinks(
            rr.FileSink(path),
            *([] if server is None else [_served(server)]),
            default_blueprint=blueprint(tree, scene, live=self._live),
        )
        if server is not None:
            _check(server)
        self._panels = (
            TreePanel(self._stream, tree),
            WordsPanel(self._stream, tree),
            ScenePanel(self._stream, model, scene),
            CameraPanel(self._stream),
            SignalsPanel(self._stream, model.limits),
        )

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add snapshots, in order of time; at least one."""
        for panel in self._panels:
            panel.write(batch)

    def close(self) -> None:
        """Write out and close the file; viewers are no longer served."""
        self._stream.flush()
        if self._live:
            threading.Event().wait(_FAREWELL)
        self._stream.disconnect()


def _check(server: Address) -> None:
    """Raise what the sink does not: that it did not get its port."""
    try:
        socket.create_connection((server.host, server.port), timeout=_PATIENCE).close()
    except OSError as error:
        raise ViewError(
            f"nothing can be served on {server.host}:{server.port} ({error.strerror}); "
            "choose another --view-port, or --view none"
        ) from error


def _served(server: Address) -> rr.GrpcServerSink:
    return rr.GrpcServerSink(
        bind_ip=server.host, port=server.port, server_memory_limit=_SERVER_MEMORY
    )
