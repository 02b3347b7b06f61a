"""A status display on standard error: the active node, its message and the figures of the run.

In a terminal it stays in place; elsewhere a plain line is printed every few seconds, which keeps a
log file readable.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from rich.console import Console
from rich.live import Live
from rich.text import Text

from app.live.nodes import path_from_root, tip
from app.live.throttle import Throttle
from app.terminal import Terminal
from hw import stopwatch

if TYPE_CHECKING:
    from app.live.nodes import NodeInfo
    from app.live.snapshot import Snapshot

_LIVE_PERIOD = 0.2
_PLAIN_PERIOD = 10.0
_LONGEST_NAME = 22
_NAMES_SHOWN = 3
_STYLES = {"RUNNING": "cyan", "SUCCESS": "green", "FAILURE": "red", "INVALID": "dim"}


class StatusLine:
    """Shows the newest snapshot; use it in a `with` statement.

    Args:
        tree: the nodes of the tree, in preorder.
        seconds: real time from an arbitrary start [s].
        console: where to write; standard error by default.
    """

    def __init__(
        self,
        tree: Sequence[NodeInfo],
        *,
        seconds: Callable[[], float] = stopwatch,
        console: Console | None = None,
    ) -> None:
        self._tree = tuple(tree)
        self._seconds = seconds
        self._console = console or Terminal(stderr=True)
        self._live: Live | None = None
        if self._console.is_terminal:
            self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._began = seconds()
        self._throttle = Throttle(_LIVE_PERIOD)
        if self._live is None:
            self._throttle = Throttle(_PLAIN_PERIOD, start=self._began + _PLAIN_PERIOD)

    def __enter__(self) -> StatusLine:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            with suppress(OSError):  # the terminal is gone
                self._live.stop()

    def update(self, snapshot: Snapshot, *, placed: int, attempts: int) -> None:
        """Show a snapshot, unless the last one was shown only a moment ago.

        Args:
            snapshot: the tick to show.
            placed: objects placed so far.
            attempts: grasps attempted so far.
        """
        now = self._seconds()
        if not self._throttle.due(now):
            return
        line = self._line(snapshot, now - self._began, placed, attempts)
        if self._live is None:
            self._console.print(line, soft_wrap=True)
        else:
            self._live.update(line, refresh=True)

    def _line(self, snapshot: Snapshot, elapsed: float, placed: int, attempts: int) -> Text:
        index = tip(snapshot.nodes)
        node = snapshot.nodes[index]
        names = [_shortened(self._tree[i].name) for i in path_from_root(self._tree, index)]
        hidden = "… / " if len(names) > _NAMES_SHOWN else ""
        speed = f"{snapshot.stamp / elapsed:.1f}x" if elapsed > 0.0 else "-"
        figures = (
            f"{snapshot.stamp:.1f} s ({speed})  placed {placed}  attempts {attempts}  "
            f"tick {snapshot.signals.tick_ms:.1f} ms"
        )
        text = Text(figures, style="dim")
        text.append("\n" if self._live is not None else "  ")
        text.append(hidden + " / ".join(names[-_NAMES_SHOWN:]), style=_STYLES[node.status.value])
        if node.message:
            text.append(f": {' '.join(node.message.split())}", style="default")
        text.no_wrap = self._live is not None
        text.overflow = "ellipsis"
        return text


def _shortened(name: str) -> str:
    return name if len(name) <= _LONGEST_NAME else name[: _LONGEST_NAME - 1] + "…"
