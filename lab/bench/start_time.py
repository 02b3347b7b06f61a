"""Time from a command to its first words, to the first motion, and to the end of a check.

Each is a process of its own with a pseudo-terminal. The first words are the first letters that it
writes; the first motion is the first picture of the running tree, which is drawn at most 0.2 s
after the first tick, and the first tick commands motion.
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
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from config import UserError
from hw import stopwatch
from lab.bench.timing import Timing, TimingReport

_CONTROL = re.compile(rb"\x1b\[[0-9;?]*[a-zA-Z]")
_LETTERS = re.compile(rb"[A-Za-z]{3}")
_RUNNING = b"times real time"
"""Text above the tree from the second tick on."""
_PATIENCE = 120.0
_PROGRAM = (sys.executable, "-m", "frankie_task_cli")
_ROWS, _COLUMNS = 40, 120
_NODES = 200
_CHECKED = "task: checked\ntree:\n  sequence:\n" + (_NODES // 2) * (
    "    - say: {text: 'all is well'}\n    - wait: {duration_s: 1}\n      retry: 2\n"
)


class StartError(UserError):
    """A run did not start."""


def time_start(tree: Path, runs: int = 5) -> TimingReport:
    """Start a task several times, one after the other; each is stopped once it moves.

    Raises:
        StartError: a run ended before it moved.
    """
    seconds = np.array([(*_start(tree), _check()) for _ in range(runs)])
    names = ("to the first words", "to the first motion", f"to the end of a check of {_NODES}")
    return TimingReport(
        timings=[Timing.of(name, 1e9 * times) for name, times in zip(names, seconds.T, strict=True)]
    )


def _check() -> float:
    """Duration of `frankie-task check` [s]."""
    with TemporaryDirectory() as folder:
        task = Path(folder) / "checked.yaml"
        task.write_text(_CHECKED, encoding="utf-8")
        begun = stopwatch()
        subprocess.run([*_PROGRAM, "check", str(task)], stdout=subprocess.DEVNULL, check=True)
        return stopwatch() - begun


def _start(tree: Path) -> tuple[float, float]:
    """Time to the first words, and to the first motion [s]."""
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
            return _until_motion(ours, begun)
        finally:
            process.send_signal(signal.SIGINT)
            while _read(ours):  # so that the process can write on until it has ended
                pass
            process.wait()
            os.close(ours)


def _until_motion(terminal: int, begun: float) -> tuple[float, float]:
    words, written = 0.0, b""
    while stopwatch() - begun < _PATIENCE:
        if not (read := _read(terminal)):
            break
        written = _CONTROL.sub(b"", written + read)
        if not words and _LETTERS.search(written):
            words = stopwatch() - begun
        if _RUNNING in written:
            return words, stopwatch() - begun
    last = written.decode(errors="replace").strip().splitlines()[-1:] or ["nothing was written"]
    raise StartError(f"the run did not start: {last[0]}")


def _read(terminal: int) -> bytes:
    """The next output; empty at the end."""
    ready, _, _ = select.select([terminal], [], [], _PATIENCE)
    try:
        return os.read(terminal, 65536) if ready else b""
    except OSError:  # the process has closed it
        return b""
