"""First drive of a base: commanded against measured speed, and whether it obeys the throttle.

The user confirms each step. The base moves little faster than the slowest velocity outside its dead
zone, whether or not it obeys the throttle: the ratios are the same.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from hw.clock import WallClock, stopwatch
from hw.hardware.arming import check_armed
from hw.hardware.drivers import base_of, site_of
from hw.hardware.findings import Finding, Verdict
from hw.hardware.lock import RobotLock
from hw.omron import OmronBase, Velocity
from hw.robot import HardwareError
from robots import RealRobot, load_robot

_FAST, _SLOW = 1.2, 0.5  # speeds of two steps, relative to the slowest one outside the dead zone
_WITHOUT = 0.1  # speed where there is no dead zone [m/s]
_MOST = 0.3  # highest speed of a step [m/s]
_SECONDS, _SETTLED, _PERIOD = 3.0, 1.0, 0.02
"""Duration of a step, settling time, and period of commands [s]."""
_SPAN = 10  # speeds are differences of poses this many commands apart; their median counts
_REST, _STANDS = 4.0, 0.005  # longest time to come to rest [s], and speed at rest [m/s]
_FITS = 0.1  # relative tolerance of the measured speed


class Step(NamedTuple):
    """Result of one step."""

    speed: float  # measured along its heading, by poses [m/s]
    faults: tuple[str, ...]


def first_metre(
    real: RealRobot, *, armed: bool, confirm: Callable[[str], bool]
) -> Iterator[Finding]:
    """Drive a base a short way, slowly.

    Args:
        real: the robot.
        armed: whether the user has armed it.
        confirm: asks the user before each step.

    Raises:
        NotArmedError: it is not armed.
        CommandedError: another program commands it.
        HardwareError: the base cannot be reached.
    """
    check_armed(real, armed)
    least = site_of(real.hardware.base.scale).least(Velocity(1.0, 0.0)).v
    commanded = _FAST * least or _WITHOUT
    if commanded > _MOST:
        text = f"its dead zone ends at {least:.2f} m/s only; make it smaller in MobilePlanner"
        yield Finding("first metre", Verdict.BAD, text)
        return
    lock = RobotLock(real.hardware).take()
    try:
        base = base_of(real.hardware, load_robot(real.path).limits, WallClock(), throttle=True)
        base.connect()
        try:
            yield from _steps(base, commanded, _SLOW * least, confirm)
        finally:
            base.close()
    finally:
        lock.release()


def _steps(
    base: OmronBase, commanded: float, slow: float, confirm: Callable[[str], bool]
) -> Iterator[Finding]:
    step = _ask_and_drive(base, commanded, confirm)
    if step is None or not _fits(step.speed, commanded):
        yield _of_speed(step, commanded)
        return
    yield _of_speed(step, commanded)
    if not slow:
        yield Finding("throttle", Verdict.GOOD, "no dead zone of forwards: it is not needed")
        return
    step = _ask_and_drive(base, slow, confirm)
    if step is None:
        yield _not_done("throttle")
    elif _fits(step.speed, slow):
        text = f"commanded {slow:.3f} m/s by the throttle, measured {step.speed:.3f}: it is heeded"
        yield Finding("throttle", Verdict.GOOD, text)
    else:
        yield Finding("throttle", Verdict.OPEN, f"it is not heeded: {_text(step, slow)}")


def _of_speed(step: Step | None, commanded: float) -> Finding:
    if step is None:
        return _not_done("speed")
    if _fits(step.speed, commanded):
        text = f"commanded {commanded:.3f} m/s, measured {step.speed:.3f}"
        return Finding("speed", Verdict.GOOD, text)
    return Finding(
        "speed",
        Verdict.BAD,
        f"{_text(step, commanded)}; compare `full_scale` with its Teleop settings",
    )


def _text(step: Step, commanded: float) -> str:
    return "; ".join((f"commanded {commanded:.3f} m/s, measured {step.speed:.3f}", *step.faults))


def _not_done(about: str) -> Finding:
    return Finding(about, Verdict.OPEN, "not done: nobody confirmed it")


def _fits(measured: float, commanded: float) -> bool:
    return abs(measured - commanded) <= _FITS * commanded + _STANDS


def _ask_and_drive(
    base: OmronBase, commanded: float, confirm: Callable[[str], bool]
) -> Step | None:
    question = (
        f"The base drives ahead for {_SECONDS:g} s at {commanded:.3f} m/s, "
        f"{_SECONDS * commanded:.1f} m. "
        "Are 1.5 m before it free, and is the emergency stop in your hand?"
    )
    return _drive(base, commanded) if confirm(question) else None


def _drive(base: OmronBase, commanded: float) -> Step:
    """Drive ahead, and wait until the base is at rest."""
    twist, begun = np.array([commanded, 0.0, 0.0]), stopwatch()
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
    return Step(float(np.median(speeds)), faults)


def _come_to_rest(base: OmronBase) -> None:
    until = stopwatch() + _REST
    while abs(base.read().twist[0]) > _STANDS:
        if stopwatch() > until:
            raise HardwareError("the base does not stop when it is told to: press its button")
        time.sleep(_PERIOD)
