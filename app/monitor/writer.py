"""The file: a Rerun stream with its blueprint, and the panels that fill it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import rerun as rr

from app.monitor.blueprint import blueprint
from app.monitor.camera_panel import CameraPanel
from app.monitor.scene_panel import ScenePanel
from app.monitor.signals_panel import SignalsPanel
from app.monitor.snapshot import NodeInfo, SceneView, Snapshot
from app.monitor.tree_panel import TreePanel
from controller import RobotModel

APPLICATION = "frankie-task"
"""The viewer keeps a person's changes of the layout under this name."""


class Writer:
    """Writes batches of snapshots to a file; to be used by one thread at a time.

    Args:
        path: the file to write.
        tree: the nodes of the tree, in preorder.
        model: kinematics of the robot; the writer's alone.
        scene: what the world looks like.

    Raises:
        RuntimeError: the file cannot be written.
    """

    def __init__(
        self, path: Path, *, tree: Sequence[NodeInfo], model: RobotModel, scene: SceneView
    ) -> None:
        rr.set_strict_mode(True)  # mistakes are raised, not turned into a warning on the terminal
        self._stream = rr.RecordingStream(APPLICATION)
        self._stream.save(path, default_blueprint=blueprint(tree, scene))
        self._panels = (
            TreePanel(self._stream, tree),
            ScenePanel(self._stream, model, scene),
            CameraPanel(self._stream),
            SignalsPanel(self._stream, model.limits),
        )

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add snapshots, in order of time; at least one."""
        for panel in self._panels:
            panel.write(batch)

    def close(self) -> None:
        """Write out and close the file."""
        self._stream.flush()
        self._stream.disconnect()
