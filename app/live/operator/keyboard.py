"""Control by keys, where standard input is a terminal and this process is in its foreground."""

import os
import select
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from app.live.operator.control import Control
from hw import HardwareError, begun

HELP = (
    "space: pause   r: resume   s: step   n: run to the next status change   q: stop   "
    "a: acknowledge an emergency stop"
)


def in_terminal(file: int) -> bool:
    """Whether keys pressed in a terminal arrive at this file descriptor."""
    try:
        return os.isatty(file) and os.tcgetpgrp(file) == os.getpgrp()
    except OSError:
        return False


@contextmanager
def keys(control: Control, file: int = 0) -> Iterator[bool]:
    """Listen to keys of a terminal within the context; yields whether they are heard.

    They are not without a terminal, or where no thread is left. The terminal's settings are
    restored at the end.
    """
    if not in_terminal(file):
        yield False
        return
    actions: dict[bytes, Callable[[], None]] = {
        b" ": control.pause,
        b"r": control.resume,
        b"s": control.step,
        b"n": control.run_to_next_change,
        b"q": control.stop,
        b"a": control.acknowledge,
    }
    before = termios.tcgetattr(file)
    end, ended = os.pipe()
    listener = None
    try:
        tty.setcbreak(file, termios.TCSADRAIN)
        with suppress(HardwareError):  # no thread can be started; Ctrl-C still ends the run
            listener = begun(_listen, "keys", file, end, actions)
        yield listener is not None
    finally:
        os.write(ended, b".")
        if listener is not None:
            listener.join()
        with suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(file, termios.TCSADRAIN, before)
        os.close(end)
        os.close(ended)


def _listen(file: int, end: int, actions: dict[bytes, Callable[[], None]]) -> None:
    with suppress(OSError):  # the terminal is gone
        while end not in select.select([file, end], [], [])[0]:
            pressed = os.read(file, 1)
            if not pressed:
                return
            if action := actions.get(pressed.lower()):
                action()
