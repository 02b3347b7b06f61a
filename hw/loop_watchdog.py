"""Watchdog thread: stops the robot when the control loop stands still.

The loop feeds it once a tick. Otherwise it stops the robot, then interrupts the loop, then has the
process ended. Time in which the whole process was suspended does not count. Code that keeps
Python's interpreter lock blocks this thread, too; then the watchdogs of the drivers act.
"""

import ctypes
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from operator import itemgetter
from typing import Self

from hw.clock import stopwatch
from hw.robot import HardwareError
from hw.threads import begun

_NAP = 0.02  # period of the watchdog [s]
_LONGEST_NAP = 0.1  # a longer nap means that the process was suspended [s]
_SIGNAL = signal.SIGALRM


class LoopBlockedError(BaseException):
    """Raised in the control loop by the watchdog; no `except Exception` swallows it."""


@dataclass(frozen=True, kw_only=True)
class Patience:
    """Duration of a tick after which the watchdog acts [s of real time]."""

    stop: float = 0.18  # the robot is stopped
    interrupt: float = 1.2  # the loop is interrupted
    abandon: float = 4.0  # the process is ended


SIMULATION = Patience(stop=inf, interrupt=60.0, abandon=90.0)  # its time waits for the tick


class Watchdog:
    """Watches the thread that enters it in a `with`, and calls from two threads of its own.

    Entering raises HardwareError: the computer starts no more threads. Later it needs none.
    """

    def __init__(
        self,
        stop: Callable[[], None],
        abandon: Callable[[], None] = lambda: None,
        patience: Patience | None = None,
    ) -> None:
        self.stalls = 0  # number of ticks that took too long
        self.failure = ""  # why the robot was not stopped in the last of them
        self._patience = patience or Patience()
        actions = (
            (self._patience.stop, self._halt),
            (self._patience.interrupt, self._interrupt),
            (self._patience.abandon, abandon),
        )
        self._actions = sorted(actions, key=itemgetter(0))  # one that never comes holds none up
        self._stop = stop
        self.is_interrupting = False  # the loop was told to raise, and has not gone on
        self._is_fed = False
        self._over, self._stalled = threading.Event(), threading.Event()
        self._loop = 0

    def __enter__(self) -> Self:
        self._loop = threading.get_ident()
        begun(self._stop_stalled, "stop")
        try:
            self._thread = begun(self._watch, "watchdog")
        except HardwareError:
            self._end()
            raise
        if self._is_main:
            self._before = signal.signal(_SIGNAL, self._raise)
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(LoopBlockedError):  # that was late: the loop has ended
            self._end()
            self._thread.join()
        self._end()
        self.is_interrupting = False
        if self._is_main:
            signal.signal(_SIGNAL, self._before)

    def feed(self) -> None:
        """Tell that the loop goes on; once a tick."""
        self._is_fed = True
        self.is_interrupting = False

    @property
    def _is_main(self) -> bool:
        """Whether the loop runs in the main thread, which signals reach."""
        return self._loop == threading.main_thread().ident

    def _end(self) -> None:
        """Let both threads end; a `stop` that blocks is not waited for."""
        self._over.set()
        self._stalled.set()

    def _watch(self) -> None:
        waited, done = 0.0, 0
        looked = stopwatch()
        while not self._over.wait(_NAP):
            napped, looked = stopwatch() - looked, stopwatch()
            if self._is_fed:
                self._is_fed, waited, done = False, 0.0, 0
                continue
            waited += min(napped, _LONGEST_NAP)
            while done < len(self._actions) and waited >= self._actions[done][0]:
                done += 1
                with suppress(Exception):  # one that fails does not keep the next from its turn
                    self._actions[done - 1][1]()

    def _halt(self) -> None:
        self.stalls += 1
        self._stalled.set()

    def _stop_stalled(self) -> None:
        """Stop the robot at each stall; a `stop` that blocks does not block the watchdog."""
        while self._stalled.wait() and not self._over.is_set():
            self._stalled.clear()
            try:
                self._stop()
            except Exception as error:
                self.failure = f"the watchdog could not stop the robot ({error or repr(error)})"

    def _interrupt(self) -> None:
        self.is_interrupting = True
        if self._is_main:
            signal.pthread_kill(self._loop, _SIGNAL)  # ends system calls that wait, too
        else:
            error = ctypes.py_object(LoopBlockedError)
            ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._loop), error)

    def _raise(self, *_: object) -> None:
        """Raise in the loop on a signal, unless that went on in the meantime."""
        if self.is_interrupting:
            self.is_interrupting = False
            raise LoopBlockedError
