"""Threads that run from the moment they are made, so that no work fails later for want of one."""

import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import ParamSpec

from hw.clock import Clock, Result
from hw.robot import HardwareError

P = ParamSpec("P")

_FULL = "this computer starts no more threads: end what else runs, or raise its limit (ulimit -u)"


def begun(work: Callable[..., object], name: str, *arguments: object) -> threading.Thread:
    """A daemon thread that does the work; HardwareError: the computer starts no more."""
    thread = threading.Thread(target=work, name=name, args=arguments, daemon=True)
    try:
        thread.start()
    except (RuntimeError, MemoryError) as error:
        raise HardwareError(_FULL) from error
    return thread


def one_thread() -> ThreadPoolExecutor:
    """One thread, which does one piece of work after the other; raises HardwareError."""
    executor = ThreadPoolExecutor(max_workers=1)
    try:
        executor.submit(int).result()
    except (RuntimeError, MemoryError) as error:
        raise HardwareError(_FULL) from error
    return executor


class Worker(Executor):
    """One thread whose results are there when the clock says so.

    Args:
        clock: of the session.
        seconds: from the call of `submit` to the result, in simulated time [s].

    Raises HardwareError: the computer starts no more threads.
    """

    def __init__(self, clock: Clock, seconds: float) -> None:
        self._thread, self._clock = one_thread(), clock
        self._seconds = seconds

    def submit(
        self, fn: Callable[P, Result], /, *args: P.args, **kwargs: P.kwargs
    ) -> Future[Result]:
        """Begin the work."""
        return self._clock.due(self._thread.submit(fn, *args, **kwargs), self._seconds)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the thread."""
        self._thread.shutdown(wait, cancel_futures=cancel_futures)
