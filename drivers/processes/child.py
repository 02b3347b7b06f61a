"""Side of a driver process: requests and answers in JSON, and its end after its parent."""

import json
import os
import queue
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any, NoReturn

from hw.claims import Claim, holder_of
from hw.clock import stopwatch
from hw.system import run_at, stat_of

_CHECK = 0.1  # period of the check whether the parent is suspended [s]
_SUSPENDED = 0.5  # after which a suspended parent counts as gone [s]
_HUNG = 2.0  # after which the system ends a hung process [s]
_PRIORITY = 20  # real-time priority

Request = dict[str, Any]


class EndError(Exception):
    """Why the process ends, in words for people."""


class Parent:
    """The process that commands this one; `at_once` does urgent requests in a thread, or not."""

    def __init__(self, at_once: Callable[[Request], bool] = lambda _: False) -> None:
        self._at_once = at_once
        self._pid = os.getppid()
        self._requests: queue.SimpleQueue[Request] = queue.SimpleQueue()
        self._checked = 0.0
        self._suspended_since: float | None = None
        self._claim: Claim | None = None
        self.is_gone = False  # it has ended, or has told this process to end
        threading.Thread(target=self._listen, daemon=True).start()

    def tell(self, **message: Any) -> None:
        """Send one line; ignored if the parent is gone."""
        try:
            os.write(1, json.dumps(message).encode() + b"\n")
        except OSError:
            self.is_gone = True

    def claim(self, machine: str) -> None:
        """Claim a machine for the lifetime of this process; EndError: another program has it."""
        self._claim = Claim(machine).take()
        if self._claim is None:
            driver = holder_of(machine)
            above = stat_of(driver or 0)[1:2]  # the program that the driver works for
            pid = above[0] if above else driver or "that ends now"
            raise EndError(f"another program on this computer commands it already (process {pid})")

    def request(self, patience: float = 0.0) -> Request | None:
        """The next request; None if there is none within `patience` [s]."""
        try:
            return self._requests.get(timeout=patience) if patience else self._requests.get_nowait()
        except queue.Empty:
            return None

    def answer(self, request: Request, error: str = "") -> None:
        """Report that a request is done, or why not."""
        self.tell(id=request["id"], error=error)

    def commands(self) -> bool:
        """Whether it is there and not suspended."""
        now = stopwatch()
        if now - self._checked > _CHECK:
            self._checked = now
            self.is_gone |= os.getppid() != self._pid
            if stat_of(self._pid)[:1] not in (["T"], ["t"]):
                self._suspended_since = None
            elif self._suspended_since is None:
                self._suspended_since = now
            elif now - self._suspended_since > _SUSPENDED:
                self.is_gone = True
        return not self.is_gone

    def _listen(self) -> None:
        try:
            for line in sys.stdin:
                request = json.loads(line)
                if request["do"] == "end":
                    break
                if not self._at_once(request):
                    self._requests.put(request)
        finally:  # whatever it was: nobody would hear a stop
            self.is_gone = True


def serve(
    work: Callable[[Parent, str, Any, int], None],
    explain: Callable[[Exception], str],
    at_once: Callable[[Request], bool] = lambda _: False,
) -> None:
    """Work for a parent until it ends, and tell it what `work` raises.

    `work` gets the parent, and the arguments of this process: the address, the settings, and the
    descriptor of the shared memory.
    """
    address, settings, memory = sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3])
    parent = Parent(at_once)
    try:
        work(parent, address, settings, memory)
    except Exception as error:
        parent.tell(error=str(error) if isinstance(error, EndError) else explain(error))
        leave(1)
    leave()


def still_alive(patience: float = _HUNG) -> None:
    """Restart the timer that ends this process if it hangs."""
    signal.setitimer(signal.ITIMER_REAL, patience)


def hurry() -> None:
    """Request real-time priority, if the system allows it."""
    run_at(_PRIORITY)


def leave(code: int = 0) -> NoReturn:
    """End at once, without cleanup by the vendor's library: on a dead link it aborts."""
    os._exit(code)
