"""First drive of a base: commanded against measured speed.

The user confirms it. The base moves little faster than the slowest velocity outside its dead zone.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from hw.clock import WallClock, stopwatch
from hw.hardware.arming import check_armed
from hw.hardware.computer import Finding, Verdict
from hw.hardware.drivers import base_of, site_of
from hw.hardware.lock import RobotLock
from hw.omron import OmronBase, Velocity
from hw.robot import HardwareError
from robots import RealRobot, load_robot

_FAST = 1.2  # speed, relative to the slowest one outside the dead zone
_WITHOUT = 0.1  # speed where there is no dead zone [m/s]
_MOST = 0.3  # highest speed [m/s]
_SECONDS, _SETTLED, _PERIOD = 3.0, 1.0, 0.02
"""Duration, settling time, and period of commands [s]."""
_SPAN = 10  # speeds are differences of poses this many commands apart; their median counts
_REST, _STANDS = 4.0, 0.005  # longest time to come to rest [s], and speed at rest [m/s]
_FITS = 0.1  # relative tolerance of the measured speed


def first_metre(
    real: RealRobot, *, armed: bool, confirm: Callable[[str], bool]
) -> Iterator[Finding]:
    """Drive a base that the user has `armed` a short way, slowly, once the user has confirmed it.

    Raises:
        NotArmedError: it is not armed.
        CommandedError: another program commands it.
        HardwareError: the base cannot be reached.
    """
    check_armed(real, armed)
    least = site_of(real.hardware.base.scale).least(Velocity(1.0, 0.0)).v
    speed = _FAST * least or _WITHOUT
    if speed > _MOST:
        text = f"its dead zone ends at {least:.2f} m/s only; make it smaller in MobilePlanner"
        yield Finding("first metre", Verdict.BAD, text)
        return
    lock = RobotLock(real.hardware).take()
    try:
        base = base_of(real.hardware, load_robot(real.path).limits, WallClock())
        base.connect()
        try:
            question = (
                f"The base drives ahead for {_SECONDS:g} s at {speed:.3f} m/s, "
                f"{_SECONDS * speed:.1f} m. "
                "Are 1.5 m before it free, and is the emergency stop in your hand?"
            )
            if confirm(question):
                yield _drive(base, speed)
            else:
                yield Finding("speed", Verdict.OPEN, "not done: nobody confirmed it")
        finally:
            base.close()
    finally:
        lock.release()


def _drive(base: OmronBase, speed: float) -> Finding:
    """Drive ahead, wait until the base is at rest, and judge its speed along its heading."""
    twist, begun = np.array([speed, 0.0, 0.0]), stopwatch()
    places: list[tuple[float, float]] = []
    faults: tuple[str, ...] = ()
    start = base.read().wTb
    try:
        while not faults and stopwatch() - begun < _SECONDS:
            base.send(twist)
            time.sleep(_PERIOD)
            state = base.read()
            faults = tuple(fault.text for fault in state.faults)
            places.append((stopwatch() - begun, float(start.actInv(state.wTb).translation[0])))
    finally:
        base.stop()
    _come_to_rest(base)
    settled = [place for place in places if place[0] > _SETTLED] or places[-_SPAN:]
    pairs = list(zip(settled, settled[_SPAN:], strict=False)) or [(settled[0], settled[-1])]
    speeds = [(there - here) / (end - begin or _PERIOD) for (begin, here), (end, there) in pairs]
    measured = float(np.median(speeds))
    text = f"commanded {speed:.3f} m/s, measured {measured:.3f}"
    if abs(measured - speed) <= _FITS * speed + _STANDS:
        return Finding("speed", Verdict.GOOD, text)
    hint = "compare `full_scale` with its Teleop settings"
    return Finding("speed", Verdict.BAD, "; ".join((text, *faults, hint)))


def _come_to_rest(base: OmronBase) -> None:
    until = stopwatch() + _REST
    while abs(base.read().twist[0]) > _STANDS:
        if stopwatch() > until:
            raise HardwareError("the base does not stop when it is told to: press its button")
        time.sleep(_PERIOD)
