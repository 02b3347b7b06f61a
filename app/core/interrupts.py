"""Signals that end a run: the first brings the robot to rest, the second ends the process."""

import os
import signal
import termios
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, NoReturn

from hw import HardwareError, begun

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_PATIENCE = 0.5  # a robot that does not stop within this time is left to its own watchdog [s]


@contextmanager
def interrupts(
    stop_run: Callable[[], None], stop_robot: Callable[[], None], exit_code: int
) -> Iterator[None]:
    """Handle Ctrl-C, SIGTERM and SIGHUP within the context; does nothing off the main thread.

    The first signal calls `stop_run`; the second stops the robot and ends the process.
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

    before = {number: signal.signal(number, handle) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def leave(stop_robot: Callable[[], None], exit_code: int, terminal: list[Any] | None) -> NoReturn:
    """Stop the robot on a thread of its own, restore the terminal, and end the process."""
    with suppress(HardwareError):  # without a thread the robot's own watchdogs stop it
        begun(stop_robot, "stop").join(_PATIENCE)
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
