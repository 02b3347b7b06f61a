"""Terminal display of a run, on standard error.

In a terminal the tree stays in place; elsewhere every change is one line, which keeps a log file
readable. A thread of its own writes; the loop only leaves the newest snapshot.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from rich.console import Console
from rich.live import Live

from app.live.tree_text import Changes, Moment, RunInfo, picture
from app.terminal import Terminal
from hw import stopwatch

if TYPE_CHECKING:
    from app.live.nodes import NodeInfo

_PERIOD = 0.2
"""Interval of writing [s of real time]."""
_PATIENCE = 1.0
"""Time for the terminal to write the rest [s]."""


class RunDisplay:
    """Shows the snapshots of a run, on standard error by default; use it in a `with` statement."""

    def __init__(
        self, info: RunInfo, tree: Sequence[NodeInfo], *, console: Console | None = None
    ) -> None:
        self._info, self._tree = info, tuple(tree)
        self._began = stopwatch()
        self._console = console or Terminal(stderr=True)
        self._changes = Changes(info, self._tree)
        self._live: Live | None = None
        if self._console.is_terminal:
            self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._newest: Moment | None = None
        self._changed: deque[Moment] = deque()
        self._paused, self._faults = "", 0
        self._error: Exception | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="terminal", daemon=True)

    def __enter__(self) -> RunDisplay:
        if self._live is not None:
            self._live.start()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.set()
        self._thread.join(_PATIENCE)
        if self._live is not None:
            with suppress(OSError):  # the terminal is gone
                self._live.stop()

    def update(self, moment: Moment, *, changed: bool) -> None:
        """Show a tick soon; `changed` is whether the status of a node changed in it.

        Raises:
            Exception: that ended the writing of an earlier one.
        """
        if self._error is not None:
            raise self._error
        self._newest = moment
        faults = len(moment.seen.state.faults)
        if changed or moment.paused != self._paused or faults != self._faults:
            self._paused, self._faults = moment.paused, faults
            self._changed.append(moment)

    def _run(self) -> None:
        try:
            while not self._closing.wait(_PERIOD):
                self.write()
            if self._live is None:
                self.write()
        except Exception as error:  # whatever it is, the robot must go on
            self._error = error

    def write(self) -> None:
        """Write the newest state now."""
        if self._live is None:
            while self._changed:
                for line in self._changes.lines(self._changed.popleft()):
                    self._console.print(line, soft_wrap=True, markup=False, highlight=False)
            return
        self._changed.clear()
        if self._newest is not None:
            text = picture(
                self._info,
                self._tree,
                self._newest,
                elapsed=stopwatch() - self._began,
                width=self._console.width,
                rows=self._console.height - 2,
            )
            self._live.update(text, refresh=True)
