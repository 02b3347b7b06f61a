"""Texts of the recording: active node and message, and log of transitions."""

from collections.abc import Sequence

import rerun as rr
from py_trees.common import Status

from app.live.changes import Changes, LogLine
from app.live.monitor.columns import timelines
from app.live.monitor.glyphs import printable
from app.live.nodes import STATUS_GLYPH, NodeInfo, path_from_root, tip
from app.live.run_snapshot import Snapshot

_LEVELS = {"info": "INFO", "warning": "WARN", "error": "ERROR"}
_PERIOD = 0.2  # shortest time between two messages of a node [s]


class TextPanel:
    """Writes the texts."""

    def __init__(self, stream: rr.RecordingStream, tree: Sequence[NodeInfo]) -> None:
        self._stream = stream
        self._tree = tuple(tree)
        self._changes = Changes(tree)
        self._active: tuple[int, Status, str] | None = None
        self._active_since = -float("inf")

    def write(self, batch: Sequence[Snapshot]) -> None:
        """Add the texts of a batch."""
        messages: list[tuple[Snapshot, str]] = []
        events: list[tuple[Snapshot, LogLine]] = []
        for snapshot in batch:
            events += [(snapshot, line) for line in self._changes.of(snapshot)]
            text = self._changed_message(snapshot)
            if text is not None:
                messages.append((snapshot, text))
        if messages:
            texts = [text for _, text in messages]
            self._stream.send_columns(
                "now",
                indexes=timelines([snapshot for snapshot, _ in messages]),
                columns=rr.TextDocument.columns(
                    text=texts, media_type=["text/markdown"] * len(texts)
                ),
            )
        if events:
            self._stream.send_columns(
                "log",
                indexes=timelines([snapshot for snapshot, _ in events]),
                columns=rr.TextLog.columns(
                    level=[_LEVELS[line.severity] for _, line in events],
                    text=[f"{line.time:7.2f} s  {printable(line.text)}" for _, line in events],
                ),
            )

    def _changed_message(self, snapshot: Snapshot) -> str | None:
        """The active node with its message, if that has changed."""
        index = tip(snapshot.nodes)
        node = snapshot.nodes[index]
        active = (index, node.status, node.message)
        same_node = self._active is not None and active[:2] == self._active[:2]
        too_soon = snapshot.stamp < self._active_since + _PERIOD
        if active == self._active or (same_node and too_soon):
            return None
        self._active, self._active_since = active, snapshot.stamp
        names = [_escape(self._tree[i].name) for i in path_from_root(self._tree, index)]
        return (
            f"### {STATUS_GLYPH[node.status]} {names[-1]}\n\n"
            f"{_escape(node.message)}\n\n*{' / '.join(names[:-1])}*"
        )


def _escape(text: str) -> str:
    """The text escaped for Markdown, in characters that the viewer can draw."""
    return "".join(f"\\{c}" if c in r"\`*_{}[]<>()#+-.!|~" else c for c in printable(text))
