"""Driver process as seen by its parent: a crash of the vendor's library affects it alone."""

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, TypeVar

from drivers.processes.mailbox import open_memory, share_memory
from hw import Clock, Fault, FaultKind, HardwareError
from hw.clock import stopwatch
from hw.system import stat_of

Record = TypeVar("Record")

_LOADING = 30.0  # [s]
_BUSY = "this computer is too busy, its driver gets no time: end what else runs"
_QUIET = "it says nothing: look at the cable and the power"
_LIGHT = str(Path(__file__).with_name("light.py"))


class NoAnswerError(HardwareError):
    """A request was not answered in time; the process may still work on it."""


class DriverProcess:
    """One process; `start` and `end` may be repeated; `connecting` is a timeout [s]."""

    def __init__(
        self,
        module: str,
        what: str,
        address: str,
        settings: dict[str, Any],
        mailboxes: int,
        connecting: float,
        missing: Callable[[], str],
    ) -> None:
        self.what = f"{what} at {address}"
        self._command = [sys.executable, "-P", _LIGHT, module, address, json.dumps(settings)]
        self._memory = share_memory(mailboxes)
        self.memory = open_memory(self._memory)
        self._connecting, self._missing = connecting, missing
        self.process: subprocess.Popen[bytes] | None = None  # None when it was ended
        self._stderr: IO[bytes] | None = None
        self._buffer = b""
        self._asked = 0
        self._writing, self._asking, self._hearing = (threading.Lock() for _ in range(3))
        self._last_words = ""
        self._silent = (0.0, "")

    def start(self) -> None:
        """Start it and wait until it is connected; HardwareError: why not, and what to do."""
        if missing := self._missing():
            raise HardwareError(missing)
        self.end()
        self._last_words, self._buffer = "", b""
        try:
            self._stderr = tempfile.TemporaryFile()  # noqa: SIM115
            self.process = subprocess.Popen(
                [*self._command, str(self._memory)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._stderr,
                pass_fds=(self._memory,),
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
                start_new_session=True,  # Ctrl-C is for the parent
            )
        except OSError as error:
            why = f"the computer starts no more processes ({error.strerror})"
            raise HardwareError(f"the {self.what}: {why}: end what else runs") from error
        try:
            self._expect("loaded", _LOADING)
            self._expect("ready", self._connecting)
        except HardwareError:
            self.kill()
            raise

    def ask(self, timeout: float, **request: Any) -> None:
        """Send a request and wait for the answer, one after the other; raises HardwareError.

        NoAnswerError: it may or may not be done; the caller has to stop it.
        """
        with self._asking:
            self._asked += 1
            self.say(id=self._asked, **request)
            until = stopwatch() + timeout
            while True:
                message = self._message(until - stopwatch())
                if message is None:
                    raise NoAnswerError(f"the {self.what}: {self.end_of_it() or 'no answer'}")
                if message.get("id") == self._asked:
                    if message["error"]:
                        raise HardwareError(f"the {self.what}: {message['error']}")
                    return
                if "id" not in message:
                    self._last_words = message.get("error", "")

    def told(self, record: Record | None) -> Record:
        """The newest record of the process; HardwareError: there never was one."""
        if record is None:
            raise HardwareError(f"the {self.what}: {self.end_of_it()}")
        return record

    def say(self, **request: Any) -> None:
        """Send a request; ignored if the process has ended."""
        process = self.process
        if process is None or process.stdin is None:
            return
        with self._writing, suppress(OSError, ValueError):
            process.stdin.write(json.dumps(request).encode() + b"\n")
            process.stdin.flush()

    def silence(self, stamp: float, longest: float) -> str:
        """Why there is no new reading, if the newest one is too old; empty otherwise."""
        if ended := self.end_of_it():
            return ended
        if stopwatch() - stamp <= longest:
            return ""
        if self._silent[0] != stamp:  # a silence has one reason
            self._silent = (stamp, _BUSY if self._is_starved() else _QUIET)
        return self._silent[1]

    def end_of_it(self) -> str:
        """Why the process has ended; empty while it runs."""
        process = self.process
        if process is None:
            return self._last_words or "its driver is not running"
        if process.poll() is None:
            return ""
        # A thread that waits for an answer reads the last words itself.
        if not self._last_words and self._hearing.acquire(blocking=False):
            try:
                while (message := self._next_line(0.0)) is not None:
                    self._last_words = message.get("error") or self._last_words
            finally:
                self._hearing.release()
        return self._last_words or f"its driver has ended: {self._cause(process.returncode)}"

    def end(self, patience: float = 2.0) -> None:
        """Ask it to end; kill it if it does not."""
        process = self.process
        if process is None:
            return
        self.say(do="end")
        try:
            process.wait(patience)
        except subprocess.TimeoutExpired:
            process.kill()
        self.kill()

    def kill(self) -> None:
        """End it at once."""
        process, self.process = self.process, None
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout, self._stderr):
                if stream is not None:
                    with suppress(OSError):
                        stream.close()

    def _is_starved(self) -> bool:
        process = self.process
        return process is not None and stat_of(process.pid)[:1] in (["R"], ["T"], ["t"])

    def __del__(self) -> None:
        self.kill()
        os.close(self._memory)

    def _expect(self, what: str, timeout: float) -> None:
        message = self._message(timeout)
        if message is None:
            silent = "it accepts the connection and says nothing: does another program command it?"
            raise HardwareError(f"the {self.what}: {self.end_of_it() or silent}")
        if "error" in message:
            raise HardwareError(f"the {self.what}: {message['error']}")
        assert what in message

    def _message(self, timeout: float) -> dict[str, Any] | None:
        """The next line of the process; None on timeout or if it has ended."""
        with self._hearing:
            return self._next_line(timeout)

    def _next_line(self, timeout: float) -> dict[str, Any] | None:
        process, until = self.process, stopwatch() + timeout
        if process is None or process.stdout is None:
            return None
        while b"\n" not in self._buffer:
            ready, _, _ = select.select([process.stdout], [], [], max(0.0, until - stopwatch()))
            if not ready:
                return None
            data = os.read(process.stdout.fileno(), 4096)
            if not data:
                process.wait()
                return None
            self._buffer += data
        line, _, self._buffer = self._buffer.partition(b"\n")
        message: dict[str, Any] = json.loads(line)
        return message

    def _cause(self, code: int) -> str:
        if code == -signal.SIGALRM:
            return "it hung; the connection is frozen"
        if code == 0:
            return "this program was suspended"
        words = b""
        if self._stderr is not None:
            self._stderr.seek(0)
            words = self._stderr.read()[-2000:]
        lines = words.decode(errors="replace").split("\n")
        last = next((line for line in reversed(lines) if line.strip()), "")
        return f"exit status {code} {last}".strip()


class ProcessPart:
    """A part of a robot behind a process; its readings are on the session's clock."""

    def __init__(self, process: DriverProcess, clock: Clock) -> None:
        self._process, self._clock, self._offset = process, clock, 0.0

    def connect(self) -> None:
        """Start the process, and wait until it is connected; HardwareError: why not."""
        self._offset = self._clock.now() - stopwatch()
        self._process.start()

    def close(self) -> None:
        """Stop, and end the process."""
        self.stop()
        self._process.end()

    def stop(self) -> None:
        """Nothing moves."""

    def _fault(self, kind: FaultKind, cause: str, *, clearable: bool = True) -> Fault:
        return Fault(kind=kind, text=f"the {self._process.what}: {cause}", clearable=clearable)
