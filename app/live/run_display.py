"""Terminal display of a run, on standard error.

In a terminal the tree stays in place; elsewhere every change is one line, which keeps a log file
readable. A thread of its own writes.
"""

from collections.abc import Sequence
from contextlib import suppress
from typing import Self

from py_trees.common import Status
from rich.console import Console
from rich.live import Live
from rich.text import Text

from app.live.changes import LONGEST_NAME, Changes, RunInfo
from app.live.feed import Feed
from app.live.nodes import (
    LOOK_GLYPH,
    Look,
    NodeInfo,
    NodeStatus,
    leaves,
    looks,
    path_from_root,
    shortened,
    tip,
)
from app.live.run_snapshot import Snapshot
from app.task_time import task_time
from app.terminal import Terminal
from config import counted
from hw import stopwatch

_PERIOD = 0.2  # interval of writing [s of real time]
_PATIENCE = 1.0  # time for the terminal to write the rest [s]
_STYLES = {
    Look.IDLE: "bright_black",
    Look.RUNNING: "cyan",
    Look.SUCCESS: "green",
    Look.NOT_YET: "yellow",
    Look.FAILURE: "red",
}


class RunDisplay:
    """Shows the snapshots of a run, on standard error by default; use it in a `with` statement."""

    def __init__(
        self, info: RunInfo, tree: Sequence[NodeInfo], *, console: Console | None = None
    ) -> None:
        self._info, self._tree = info, tuple(tree)
        self._began = stopwatch()
        self._console = console or Terminal(stderr=True)
        self._changes = Changes(self._tree, info.objects)
        self._live: Live | None = None
        if self._console.is_terminal:
            self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._feed = Feed(self._write, lossless=False, period=_PERIOD, batch=400, name="terminal")

    def __enter__(self) -> Self:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._feed.close(_PATIENCE)
        if self._live is not None:
            with suppress(OSError):  # the terminal is gone
                self._live.stop()

    def show(self, snapshot: Snapshot) -> None:
        """Show a tick soon; raises Exception: that ended the writing of an earlier one."""
        self._changes.note(snapshot)
        self._feed.offer(snapshot)

    def _write(self, batch: Sequence[Snapshot]) -> None:
        """Write what is new in some snapshots."""
        if self._live is None:
            for line in self._changes.take():
                said = f"{line.time:8.2f} s  {line.text}"
                self._console.print(said, soft_wrap=True, markup=False, highlight=False)
            return
        text = picture(
            self._info,
            self._tree,
            batch[-1],
            elapsed=stopwatch() - self._began,
            width=self._console.width,
            rows=self._console.height - 2,
        )
        self._live.update(text, refresh=True)


def picture(
    info: RunInfo,
    tree: Sequence[NodeInfo],
    seen: Snapshot,
    *,
    elapsed: float,
    width: int,
    rows: int,
) -> Text:
    """The whole display: badges, figures, and the tree with the running leaf in bold.

    `elapsed` is the real time since the run began [s], `width` that of the terminal in characters
    and `rows` the number of available lines.
    """
    lines = [_head(info, seen), _figures(info, seen, elapsed)]
    lines += _tree_lines(tree, seen.nodes, rows=max(3, rows - len(lines)))
    for line in lines:
        line.no_wrap = True
        line.truncate(width, overflow="ellipsis")
    return Text("\n").join(lines)


def _head(info: RunInfo, seen: Snapshot) -> Text:
    text = Text()
    faults = [fault.text for fault in seen.state.faults]
    if faults:
        text.append(f" FAULT: {'; '.join(faults)} ", style="bold white on red").append(" ")
    if seen.paused:
        text.append(f" PAUSED {seen.paused} ", style="bold black on yellow").append(" ")
    if seen.too_slow:
        text.append(f" {seen.too_slow} ", style="bold black on yellow").append(" ")
    text.append(info.task, style="bold")
    text.append(f"  {info.where}", style="bright_black")
    return text


def _figures(info: RunInfo, seen: Snapshot, elapsed: float) -> Text:
    text = Text()
    if info.objects:
        text.append(f"{seen.placed} of {info.objects} placed", style="bold")
        text.append(f"  {counted(seen.attempts, 'grasp')}  ")
    speed = f", {seen.stamp / elapsed:.1f} times real time" if elapsed > 0.0 else ""
    text.append(f"{task_time(seen.time, seen.paused_s)}{speed}", style="bright_black")
    return text


def _tree_lines(tree: Sequence[NodeInfo], nodes: Sequence[NodeStatus], *, rows: int) -> list[Text]:
    """A line per node; if they do not fit, of the ancestors of the running leaf and that leaf."""
    running, at_end, states = tip(nodes), leaves(tree), looks(tree, nodes)
    fits = len(tree) <= rows
    shown = range(len(tree)) if fits else path_from_root(tree, running)[-rows:]
    lines = []
    for index in shown:
        node, status, style = tree[index], nodes[index], _STYLES[states[index]]
        line = Text("  " * node.depth)
        line.append(f"{LOOK_GLYPH[states[index]]} ", style=style)
        name = shortened(node.title, LONGEST_NAME)
        line.append(name, style=f"bold {style}" if index == running else style)
        message = " ".join(status.message.split())
        if index == running:
            line.append(f"  {message}")
        elif status.status is Status.FAILURE and index in at_end:
            line.append(f"  {message}", style="dim")
        lines.append(line)
    if not fits:
        lines[-1].append(f"   (+ {counted(len(tree) - len(shown), 'node')})", style="bright_black")
    return lines
