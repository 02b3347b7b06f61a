"""Writes the recording of a run, and serves it to viewers."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from app.live.feed import Feed, Throttle
from app.live.nodes import NodeInfo
from app.live.run_snapshot import SceneView, Snapshot
from app.web import Address
from config import UserError
from controller import RobotModel
from robots import RobotDescription

_PERIOD, _LIVE_PERIOD = 0.5, 0.2  # interval of writing without and with a viewer [s of real time]
_DEPTH_PERIOD = 0.4  # shortest time between two recorded depth images [s]
_PATIENCE = 30.0  # time for the disk to write the rest at the end [s]


class RecorderError(UserError):
    """A recording cannot be written, or is incomplete."""


class Recorder:
    """Writes snapshots to a file and to viewers, on a thread of its own.

    The folder of `path` exists; `tree` has the nodes in preorder; `model` is not shared, since the
    thread uses it. When the disk is slow, `lossless` lets `record` wait (a simulation at full
    speed), or else the oldest snapshots are dropped (in real time). Viewers are served at `server`.
    Raises RecorderError: the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        *,
        tree: Sequence[NodeInfo],
        model: RobotModel,
        scene: SceneView,
        lossless: bool,
        server: Address | None = None,
    ) -> None:
        with _quiet():
            from app.live.monitor.rerun_stream import Writer  # Rerun takes a second to import

        self._path = path
        try:
            self._writer = Writer(path, tree=tree, model=model, scene=scene, server=server)
        except (OSError, RuntimeError) as error:
            raise RecorderError(
                f"{path}: cannot write the recording ({error}); "
                "choose a folder that exists, is writable and has space"
            ) from error
        period = _PERIOD if server is None else _LIVE_PERIOD
        self._feed: Feed[Snapshot] = Feed(self._writer.write, lossless=lossless, period=period)
        self._depth = Throttle(_DEPTH_PERIOD)
        self._closed = False

    @property
    def dropped(self) -> int:
        """Number of snapshots dropped because writing was too slow."""
        return self._feed.dropped

    def record(self, snapshot: Snapshot) -> None:
        """Add a snapshot; never raises, and does nothing after an error or `close`."""
        if snapshot.frame is not None and not self._depth.due(snapshot.frame.stamp):
            snapshot = replace(snapshot, frame=None, detection=None)
        self._feed.put(snapshot)

    def close(self) -> None:
        """Write what is left and close the file. May be called twice.

        Raises RecorderError: the recording is incomplete; raised once.
        """
        if self._closed:
            return
        self._closed = True
        if not self._feed.close(_PATIENCE):
            raise RecorderError(
                f"{self._path}: the rest of the recording could not be written within "
                f"{_PATIENCE:.0f} s; the file ends early"
            )
        error = self._feed.error
        try:
            self._writer.close()
        except Exception as closing_error:  # Rerun raises many kinds
            error = error or closing_error
        if error is not None:
            from_disk = isinstance(error, OSError | RuntimeError)
            why = "is the disk full?" if from_disk else "please report this."
            raise RecorderError(
                f"{self._path}: the recording ends early ({type(error).__name__}: {error}); "
                f"{why} The run itself was not affected"
            ) from error


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep Rerun, imported inside, from printing errors; the summary reports them."""
    before = os.environ.get("RUST_LOG")
    os.environ["RUST_LOG"] = before or "warn,re_log_encoding=off,re_sdk=off"
    yield
    if before is None:
        del os.environ["RUST_LOG"]


def draw_robot(robot: RobotDescription, save: Path | None) -> None:
    """Draw a robot as the controller sees it, ready, in the viewer or into a .rrd file."""
    from app.live.monitor.robot_visual import draw  # Rerun takes a second to import

    draw(robot, save)
