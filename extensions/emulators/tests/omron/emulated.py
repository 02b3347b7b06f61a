"""An emulated base and the driver on it, over real sockets on ports that the system chooses."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from waiting import until

from drivers.omron import ArclOptions, OmronBase, OmronOptions
from extensions.emulators.omron import OmronEmulator
from hw import WallClock
from hw.clock import stopwatch
from hw.state import BaseState, FaultKind

SPEED = 0.15  # of the moving base: reached after 0.3 s, gone after 0.25 s [m/s]
TOLD = 0.25  # the base is told to rest within this time of the last good command [s]
PATIENCE = 60.0  # also on a busy machine [s]


def base_of(emulator: OmronEmulator, *, arcl: str = "", **settings: Any) -> OmronBase:
    """A driver for an emulated base; with the text interface where there is a password for it."""
    text = ArclOptions(password=arcl, port=emulator.arcl_port, poll=0.05) if arcl else None
    given = {"address": "127.0.0.1", "port": emulator.port, "user": "frankie", "arcl": text}
    return OmronBase(OmronOptions(**(given | settings)), WallClock())


@contextmanager
def connected(emulator: OmronEmulator, **settings: Any) -> Iterator[OmronBase]:
    """A driver that is connected, and closed in the end."""
    base = base_of(emulator, **settings)
    base.connect()
    try:
        yield base
    finally:
        base.close()


def drive(base: OmronBase, v: float = SPEED, w: float = 0.0, seconds: float = 0.4) -> float:
    """Command a twist for a while, every 10 ms; when the last command was given [s]."""
    until = stopwatch() + seconds
    while stopwatch() < until:
        base.read()
        base.send(np.array([v, 0.0, w]))
        given = stopwatch()
        time.sleep(0.01)
    return given


def set_off(emulator: OmronEmulator, base: OmronBase, v: float = SPEED) -> float:
    """Command a velocity until the base has nearly reached it; time of the last command [s]."""
    wheels, begun = emulator.controller.drive, stopwatch()
    while wheels.twist()[0] < 0.8 * v:
        assert stopwatch() - begun < PATIENCE, base.read().faults
        given = drive(base, v, seconds=0.01)
    return given


@contextmanager
def repeating(act: Callable[[], Any]) -> Iterator[None]:
    """Something is done all the time, by a thread of its own."""
    over = threading.Event()

    def work() -> None:
        while not over.wait(0.01):
            act()

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def wait_for_fault(base: OmronBase, kind: FaultKind, words: str) -> BaseState:
    """The first reading with a fault of this kind that says these words."""

    def there() -> bool:
        return any(fault.kind is kind and words in fault.text for fault in base.read().faults)

    until(there)
    return base.read()


def is_at_rest(emulator: OmronEmulator) -> bool:
    """Whether the emulated base stands, as its wheels tell."""
    return max(map(abs, emulator.controller.drive.twist())) < 1e-3


def told_to_rest(what: str, emulator: OmronEmulator, moment: float) -> float:
    """Time from a moment until the base was told to rest, for good [s]; waits until it stands.

    `pytest -rP` shows both times.
    """
    until(lambda: is_at_rest(emulator))
    moving = [one.at for one in emulator.moved if abs(one.v) > 1e-3 or abs(one.w) > 1e-3]
    last = max((one.at for one in emulator.heard if not one.is_zero), default=moment)
    told = next(one.at for one in emulator.heard if one.is_zero and one.at >= last) - moment
    print(f"{what}: told to rest after {told:.2f} s, stands after {moving[-1] - moment:.2f} s")
    return told
