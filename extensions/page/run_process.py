"""A run in another process, as what the page server shows: the other end of its socket.

When this side is closed, as by the end of the server, a run that it started comes to rest and ends.
"""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from typing import Protocol

from app.live import LogLine
from config import UserError
from extensions.page.control_page import Told
from extensions.page.log_book import LogBook
from hw import stopwatch

_FRESH = 1.0  # age from which a confirmed stop counts as unconfirmed [s]
_ASK, _TERMINATE = 1.0, 6.0
"""So long a stop is asked for, then the process is told to end, then it is killed [s]."""
_PATIENCE = 10.0  # for the process to end when the server does [s]


class ShownPage(Protocol):
    """What the server shows of one run."""

    log: LogBook

    @property
    def viewer_hosts(self) -> str:
        """To which the viewer on the page may connect."""

    def about(self) -> Told:
        """What does not change."""

    def state(self) -> Told:
        """What changes."""

    def picture(self) -> Told | None:
        """The last picture of the camera."""

    def catch_up(self) -> None:
        """Put what has happened into the log."""

    def act(self, path: str) -> bool:
        """Do what a button asks for by its path; whether there is such a button."""

    def stop(self) -> None:
        """End the run."""


class RunLink:
    """What a run tells over a connection."""

    def __init__(self, connection: socket.socket, task: str = "") -> None:
        self.log = LogBook()
        self._about: Told = {"task": task}
        self._state: Told = {"phase": "starting", "stopped": False}
        self._picture: Told | None = None
        self._heard = stopwatch()
        self._socket = connection

    @property
    def viewer_hosts(self) -> str:
        """To which the viewer on the page may connect."""
        return str(self._about.get("viewer_hosts", "'self'"))

    def about(self) -> Told:
        """What does not change."""
        return self._about

    def picture(self) -> Told | None:
        """The last picture of the camera."""
        return self._picture

    def catch_up(self) -> None:
        """Nothing to do: the run tells by itself."""

    def state(self) -> Told:
        """What the run last told, with its age, and for how long nothing was heard of it [s]."""
        told, unheard = self._state, stopwatch() - self._heard
        return told | {"age": told.get("age", 0.0) + unheard, "unheard": unheard}

    def act(self, path: str) -> bool:
        """Pass on a button."""
        if "\n" in path:
            return False
        try:  # a frozen process takes nothing, and Stop must not wait for it
            self._socket.send(path.encode() + b"\n", socket.MSG_DONTWAIT)
        except OSError:
            return False
        return True

    def stop(self) -> None:
        """End the run."""
        self.act("/stop")

    def hear(self) -> None:
        """Take what the run tells, until it tells no more."""
        with suppress(OSError, ValueError), self._socket.makefile("r", encoding="utf-8") as lines:
            for line in lines:
                news = json.loads(line)
                self._about = news.get("about", self._about)
                self._picture = news.get("picture", self._picture)
                self.log.add(LogLine(*one) for one in news.get("log", ()))
                if "state" in news:
                    self._state, self._heard = news["state"], stopwatch()


class RunProcess(RunLink):
    """Starts `frankie-task run` with arguments; `say` prints its lines.

    Raises OSError or RuntimeError: no process, file or thread can be started; nothing runs then.
    """

    def __init__(self, task: str, arguments: Sequence[str], say: Callable[[str], None]) -> None:
        self._stopped_at: float | None = None
        self._terminated = False
        self._say, self._last = say, deque[str](maxlen=8)
        self._threads = [
            threading.Thread(target=target, daemon=True) for target in (self.hear, self._read)
        ]
        with ExitStack() as undone:
            ours, theirs = socket.socketpair()
            undone.callback(ours.close)
            super().__init__(ours, task)
            with theirs:
                own = (f"--with=page:fd={theirs.fileno()}", *arguments)
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "frankie_task_cli", "run", *own],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.PIPE,
                    text=True,
                    pass_fds=(theirs.fileno(),),
                    start_new_session=True,  # Ctrl-C is for the server
                )
            undone.enter_context(self._process)
            undone.callback(self._process.kill)  # which has only begun: nothing has moved
            for thread in self._threads:
                thread.start()
            undone.pop_all()

    @property
    def is_over(self) -> bool:
        """Whether the run has ended; its process may still be about to."""
        return self._process.poll() is not None or self._state["phase"] == "over"

    def state(self) -> Told:
        """What the run last told, with its age; its end, if the process has ended."""
        if self._process.poll() is not None and not self._state.get("outcome"):
            end = {"phase": "over", "outcome": self._end(), "explanation": "\n".join(self._last)}
            return self._state | end
        return super().state()

    def stop(self) -> None:
        """End the run; called again without a confirmation, end the process.

        A killed process leaves a real robot to the watchdogs of its drivers.
        """
        now = stopwatch()
        if self._state["stopped"] and now - self._heard < _FRESH:
            return
        waited = 0.0 if self._stopped_at is None else now - self._stopped_at
        self._stopped_at = self._stopped_at or now
        if waited < _ASK:
            super().stop()
        elif waited > _TERMINATE:
            self._process.kill()
        elif not self._terminated:
            self._terminated = True  # a second signal would not wait for the robot to rest
            self._process.terminate()

    def end(self) -> None:
        """Let the robot come to rest, and wait for the end of the process."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for thread in self._threads:
            thread.join()
        self._socket.close()

    def _end(self) -> str:
        code = self._process.returncode
        if code == UserError.exit_code:
            return "the run was refused; nothing has moved"
        how = f"by {signal.Signals(-code).name}" if code < 0 else f"with code {code}"
        return f"the process of the run ended {how}"

    def _read(self) -> None:
        assert self._process.stderr is not None
        with self._process.stderr as lines:
            for line in lines:
                self._last.append(line.rstrip("\n"))
                with suppress(OSError):  # the terminal is gone; the process must not wait for it
                    self._say(self._last[-1])
