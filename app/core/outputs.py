"""All that a run leaves in its folder beside the recording, written while it goes on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.core.disk import PATIENCE, Disk
from app.core.events import EVENTS, EventLog
from app.core.folder import BT_LOG
from app.core.journal import Journal
from app.core.outcome import Outcome
from app.live import Snapshot
from hw import RecordedRobot
from trees.btcpp import BtLog
from trees.language import TreeNode


class Outputs:
    """Event log, status log, commands, states, readings, and the camera's frames on request.

    Args:
        folder: of the run.
        task: name of the task.
        nodes: of the tree, in preorder.
        robot: what it is given and gives is kept.
        attended: whether a person can acknowledge an emergency stop.
        lossless: as for `Disk`.
        frames: whether to keep the frames, which are large.

    Raises:
        FolderError: a file cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        *,
        task: str,
        nodes: Sequence[TreeNode],
        robot: RecordedRobot,
        attended: bool,
        lossless: bool,
        frames: bool,
    ) -> None:
        self._robot = robot
        self._disk = Disk(folder, lossless=lossless)
        self._events = EventLog(self._disk.file(EVENTS), task, nodes)
        self._bt_log = BtLog(nodes)
        self._bt_file = self._disk.file(BT_LOG)
        self._bt_file.add(self._bt_log.head)
        self._journal = Journal(
            folder, self._disk, attended=attended, lossless=lossless, frames=frames
        )
        robot.record(self._journal)

    def update(self, seen: Snapshot, *, paused: bool, why: str) -> bool:
        """Write down what a tick changed; returns whether the status of some node did.

        Args:
            seen: the tick.
            paused: whether the run is paused.
            why: what paused it.
        """
        self._bt_file.add(self._bt_log.changes(seen.stamp))
        return self._events.update(seen, paused=paused, why=why)

    def end(self, outcome: Outcome, time: float) -> None:
        """Write down how the run ended.

        Args:
            outcome: of the run.
            time: on the session's clock [s].
        """
        self._events.end(outcome, time)
        self._robot.end()
        self._journal.end(self._robot.broken)

    def close(self, patience: float = PATIENCE) -> list[str]:
        """Write the rest.

        Args:
            patience: time that the disk has for it [s].

        Returns:
            What could not be kept, a line each.
        """
        return [*self._disk.close(patience), *self._journal.close(patience)]
