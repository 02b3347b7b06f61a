"""Wait for Ctrl-C."""

import time

_PERIOD = 0.5
"""How long an interrupt can go unnoticed [s], at a cost that cannot be measured."""


def until_interrupted() -> None:
    """Return when a person interrupts the program.

    `signal.pause` and waiting without a limit can miss it for ever: a signal that the system gives
    to another thread, or that comes just before the call, does not wake the main thread.
    """
    try:
        while True:
            time.sleep(_PERIOD)
    except KeyboardInterrupt:
        pass
