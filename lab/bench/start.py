"""How long a person waits: for the first words, the first motion, and the end of a check.

Each is a process of its own with a terminal of its own, as a person starts it. The first words
are the first letters that it writes; the first motion is the first picture of the running tree,
which is drawn at most 0.2 s after the first tick, and the first tick commands motion. The task that
is checked has 200 nodes and names no places: those are checked against the robot, which takes twice
as long.
"""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from rich.table import Table

from config import UserError
from hw import stopwatch
from lab.shared import machine

_CONTROL = re.compile(rb"\x1b\[[0-9;?]*[a-zA-Z]")
_LETTERS = re.compile(rb"[A-Za-z]{3}")
_RUNNING = b"times real time"
"""In the figures above the tree, from the second tick on."""
_PATIENCE = 120.0
_PROGRAM = (sys.executable, "-m", "frankie_task_cli")
_ROWS, _COLUMNS = 40, 120
_NODES = 200
_CHECKED = "task: checked\ntree:\n  sequence:\n" + (_NODES // 2) * (
    "    - say: {text: 'all is well'}\n    - wait: {duration_s: 1}\n      retry: 2\n"
)


class StartError(UserError):
    """A run did not start."""


@dataclass(frozen=True)
class Start:
    """What one person waited."""

    words_s: float
    motion_s: float
    check_s: float


def time_start(tree: Path, runs: int) -> list[Start]:
    """Start a task several times, one after the other; each is stopped once it moves.

    Args:
        tree: the task.
        runs: how often.

    Raises:
        StartError: the run ended before it moved.
    """
    return [Start(*_start(tree), check_s=_check()) for _ in range(runs)]


def _check() -> float:
    """How long `frankie-task check` takes [s]."""
    with TemporaryDirectory() as folder:
        task = Path(folder) / "checked.yaml"
        task.write_text(_CHECKED, encoding="utf-8")
        begun = stopwatch()
        subprocess.run([*_PROGRAM, "check", str(task)], stdout=subprocess.DEVNULL, check=True)
        return stopwatch() - begun


def _start(tree: Path) -> tuple[float, float]:
    """To the first words, and to the first motion [s]."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", _ROWS, _COLUMNS, 0, 0))
    with TemporaryDirectory() as folder:
        begun = stopwatch()
        process = subprocess.Popen(
            [*_PROGRAM, "run", str(tree), "--view", "none", "--record", folder],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=theirs,
            env=os.environ | {"TERM": "xterm-256color"},
        )
        os.close(theirs)
        try:
            return _watched(ours, begun)
        finally:
            process.send_signal(signal.SIGINT)
            _drain(ours, process)
            os.close(ours)


def _watched(terminal: int, begun: float) -> tuple[float, float]:
    """Read what the process writes until it moves."""
    words, written = 0.0, b""
    while stopwatch() - begun < _PATIENCE:
        if not (read := _read(terminal)):
            break
        written = _CONTROL.sub(b"", written + read)
        if not words and _LETTERS.search(written):
            words = stopwatch() - begun
        if _RUNNING in written:
            return words, stopwatch() - begun
    last = written.decode(errors="replace").strip().splitlines()[-1:] or ["nothing was said"]
    raise StartError(f"the run did not start: {last[0]}")


def _read(terminal: int) -> bytes:
    """What is there; empty at the end."""
    ready, _, _ = select.select([terminal], [], [], _PATIENCE)
    try:
        return os.read(terminal, 65536) if ready else b""
    except OSError:  # the process has closed it
        return b""


def _drain(terminal: int, process: subprocess.Popen[bytes]) -> None:
    """Read on, so that the process is not held up, until it has ended."""
    while _read(terminal):
        pass
    process.wait()


def start_table(starts: list[Start]) -> Table:
    """Median and worst of the runs."""
    table = Table(title=f"from the command on, on {machine()['machine']}")
    for column in ("to the", "runs", "median [s]", "worst [s]"):
        table.add_column(column, justify="right")
    for name, seconds in (
        ("first words", [one.words_s for one in starts]),
        ("first motion", [one.motion_s for one in starts]),
        (f"end of a check of {_NODES} nodes", [one.check_s for one in starts]),
    ):
        table.add_row(name, str(len(seconds)), f"{median(seconds):.2f}", f"{max(seconds):.2f}")
    return table
