"""What happens from one snapshot to the next, as lines for a log."""

from collections.abc import Iterator, Sequence

from py_trees.common import Status

from app.live.nodes import STATUS_GLYPH, NodeInfo, leaves
from app.live.run_snapshot import Snapshot


class Happenings:
    """Tells what happens in a run: ends of nodes, starts of leaves, grasp locks, faults."""

    def __init__(self, tree: Sequence[NodeInfo]) -> None:
        self._tree = tuple(tree)
        self._leaves = frozenset(leaves(tree))
        self._last: tuple[object, ...] = ()
        self._statuses = (Status.INVALID,) * len(tree)
        self._locked = False
        self._faults: frozenset[str] = frozenset()

    def of(self, snapshot: Snapshot) -> Iterator[tuple[str, str]]:
        """Level (INFO, WARN, ERROR) and text of what has happened since the one before."""
        last, self._last = self._last, (snapshot.nodes, snapshot.locked, snapshot.state.faults)
        if self._last == last:
            return
        for index, (was, now) in enumerate(zip(self._statuses, snapshot.nodes, strict=True)):
            begins_inside = now.status is Status.RUNNING and index not in self._leaves
            if now.status not in (was, Status.INVALID) and not begins_inside:
                level = "WARN" if now.status is Status.FAILURE else "INFO"
                reason = f": {now.message}" if now.message else ""
                yield level, f"{STATUS_GLYPH[now.status]} {self._tree[index].name}{reason}"
        self._statuses = tuple(node.status for node in snapshot.nodes)
        if snapshot.locked and not self._locked:
            yield "INFO", "grasp locked"
        self._locked = snapshot.locked
        faults = frozenset(fault.text for fault in snapshot.state.faults)
        for text in sorted(faults - self._faults):
            yield "ERROR", f"fault: {text}"
        self._faults = faults
