"""Wait for Ctrl-C."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

_PERIOD = 0.5
"""How long an interrupt can go unnoticed [s], at a cost that cannot be measured."""


@contextmanager
def until_interrupted() -> Iterator[None]:
    """Do what is inside, then wait until a person interrupts the program, who may do so at once.

    `signal.pause` and waiting without a limit can miss it for ever: a signal that the system gives
    to another thread, or that comes just before the call, does not wake the main thread.
    """
    try:
        yield
        while True:
            time.sleep(_PERIOD)
    except KeyboardInterrupt:
        pass
