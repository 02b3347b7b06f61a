"""Event log of a run: transitions of nodes, faults, pauses and the end, as JSON lines.

| event | when | fields besides `time` |
|---|---|---|
| `begin` | before the first tick | `task`, `nodes`: path and what is constant, in preorder |
| `node` | a node's status changed | `tick`, `node` (its index), `status`, `message`, `values` |
| `now` | once a second | `node` (the one that decides), `message`, `values` |
| `fault` | the robot's faults changed | `faults` (texts; empty when healthy again) |
| `pause`, `resume` | a person did so | `why` |
| `end` | after the last tick | `outcome`, `reason`, `node` (index or null), `trace`, `values` |
"""

import json
from collections.abc import Sequence
from dataclasses import asdict

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from app.core.files.disk import GrowingFile
from app.core.outcome import Outcome
from app.live import Hook, Snapshot, Throttle, key_figures, tip, tree_view
from trees.language import TreeNode

EVENTS = "events.jsonl"

_ALIVE_PERIOD = 1.0  # interval of the event `now` [s]


class EventLog:
    """Writes the log of one run."""

    def __init__(self, file: GrowingFile, task: str, nodes: Sequence[TreeNode]) -> None:
        self._file = file
        self._nodes = [place.node for place in nodes]
        self._statuses = [Status.INVALID] * len(nodes)
        self._faults: tuple[str, ...] = ()
        self._paused = False
        self._alive = Throttle(_ALIVE_PERIOD)
        self._last: Snapshot | None = None
        described = [
            {"path": n.path, **asdict(info)}
            for n, info in zip(nodes, tree_view(nodes), strict=True)
        ]
        self._write("begin", 0.0, task=task, nodes=described)

    def update(self, seen: Snapshot) -> None:
        """Log the changes of a tick."""
        time, self._last = seen.stamp, seen
        faults = tuple(fault.text for fault in seen.state.faults)
        if faults != self._faults:
            self._faults = faults
            self._write("fault", time, faults=faults)
        if bool(seen.paused) != self._paused:
            self._paused = bool(seen.paused)
            self._write("pause" if seen.paused else "resume", time, why=seen.paused)
        for index, node in enumerate(seen.nodes if seen.changed else ()):
            if node.status is not self._statuses[index]:
                self._statuses[index] = node.status
                self._write(
                    "node",
                    time,
                    tick=seen.tick,
                    node=index,
                    status=node.status.value,
                    message=node.message,
                    values=key_figures(seen) if node.status is Status.FAILURE else {},
                )
        if self._alive.due(time):
            index = tip(seen.nodes)
            message = seen.nodes[index].message
            self._write("now", time, node=index, message=message, values=key_figures(seen))

    def end(self, outcome: Outcome, time: float) -> None:
        """Log how the run ended, at a time on the session's clock [s]."""
        self._write(
            "end",
            time,
            outcome=outcome.end.value,
            reason=outcome.reason,
            node=self._index(outcome.where),
            trace=outcome.trace,
            values=key_figures(self._last) if self._last is not None else {},
        )

    def _index(self, node: Behaviour | None) -> int | None:
        """Which node of the tree it is; a hook stands for the node behind it."""
        inner = node.node if isinstance(node, Hook) else node
        return self._nodes.index(inner) if inner in self._nodes else None

    def _write(self, event: str, time: float, **fields: object) -> None:
        line = {"event": event, "time": round(time, 4), **fields}
        self._file.add(
            (json.dumps(line, ensure_ascii=False) + "\n").encode(errors="backslashreplace")
        )
