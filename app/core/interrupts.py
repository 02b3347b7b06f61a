"""Signals that end a run: the first brings the robot to rest, the second ends the process."""

from __future__ import annotations

import os
import signal
import termios
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, NoReturn

_KINDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_PATIENCE = 0.5
"""A robot that does not stop within this is left to its own watchdog [s]."""


@contextmanager
def interrupts(
    stop_run: Callable[[], None], stop_robot: Callable[[], None], exit_code: int
) -> Iterator[None]:
    """Take Ctrl-C, SIGTERM and SIGHUP as long as the context lasts; the main thread alone can.

    Args:
        stop_run: asks the session to end.
        stop_robot: stops the robot at once.
        exit_code: of the process after a second signal.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked, terminal = False, terminal_settings()

    def handle(_number: int, _frame: FrameType | None) -> None:
        nonlocal asked
        if not asked:
            asked = True
            stop_run()
            return
        leave(stop_robot, exit_code, terminal)

    before = {kind: signal.signal(kind, handle) for kind in _KINDS}
    try:
        yield
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)


def leave(stop_robot: Callable[[], None], exit_code: int, terminal: list[Any] | None) -> NoReturn:
    """End the process at once, after the robot was told to stop.

    Args:
        stop_robot: stops the robot; not waited for when it takes too long.
        exit_code: of the process.
        terminal: settings to give back to the terminal; None if there is none.
    """
    stopping = threading.Thread(target=stop_robot, daemon=True)
    stopping.start()
    stopping.join(_PATIENCE)
    if terminal is not None:
        with suppress(termios.error, OSError):
            termios.tcsetattr(0, termios.TCSANOW, terminal)
    os._exit(exit_code)


def terminal_settings() -> list[Any] | None:
    """The settings of the terminal at standard input; None if it is none."""
    try:
        return termios.tcgetattr(0)
    except (termios.error, OSError):
        return None
