"""Threads that run from the moment they are made, so that no work fails later for want of one."""

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from hw.robot import HardwareError

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
