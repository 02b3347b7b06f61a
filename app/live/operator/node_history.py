"""What every node of a tree has done lately."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from py_trees.common import Status

if TYPE_CHECKING:
    from app.live.snapshot import Snapshot

MOST = 200
"""Changes that are kept of a node."""


class NodeHistory:
    """Keeps the last changes of every node; noted on one thread, read on any."""

    def __init__(self, count: int) -> None:
        self._statuses: list[Status] = [Status.INVALID] * count
        self._changes: list[deque[tuple[float, Status, str]]] = [
            deque(maxlen=MOST) for _ in range(count)
        ]

    def note(self, snapshot: Snapshot) -> None:
        """Note the nodes whose status has changed."""
        statuses = [node.status for node in snapshot.nodes]
        if statuses == self._statuses:
            return
        for index, (was, now) in enumerate(zip(self._statuses, snapshot.nodes, strict=True)):
            if now.status is not was:
                self._changes[index].append((snapshot.time, now.status, now.message))
        self._statuses = statuses

    def of(self, node: int) -> list[dict[str, object]]:
        """The changes of one node, for JSON, oldest first."""
        return [
            {"time": time, "status": status.value.lower(), "message": message}
            for time, status, message in self._changes[node].copy()
        ]
