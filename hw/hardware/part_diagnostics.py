"""Diagnostics of the parts of a robot: each is connected, read and closed."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from hw.clock import Clock, WallClock
from hw.findings import PERIOD, Examined, Finding, TellsItsSite, Verdict, ages, is_good
from hw.real_parts import parts_of
from hw.robot import HardwareError, LeftAlone
from robots import RealRobot, load_robot

_FIRST = 500  # periods in which the first image or scan comes
_OLD_STATE, _OLD_SCAN = 150.0, 300.0  # largest ages [ms]
_LEFT = 1.0  # a robot is left alone for so long at most [s] ...
_SLOW, _RESTS = 0.05, 0.01  # ... at this speed; below the other one it rests [m/s, rad/s]


def findings_of(
    kind: str, part: Any, real: RealRobot, clock: Clock, *, armed: bool = False
) -> Iterator[Finding]:
    """Faults and age of the readings of one part, or what its driver tells of it."""
    with _connected(part):
        faults = part.read().faults if hasattr(part, "read") else getattr(part, "faults", tuple)()
        yield from (Finding(kind, Verdict.BAD, fault.text) for fault in faults)
        if isinstance(part, Examined):
            yield from part.examine(load_robot(real.path))
        else:
            newest, oldest = getattr(part, "read", None), _OLD_STATE
            if newest is None:
                newest, oldest = part.latest, _OLD_SCAN
            for _ in range(_FIRST):
                if newest() is not None:
                    break
                time.sleep(PERIOD)
            yield ages(kind, "readings", lambda: _age(newest(), clock), oldest)
            if isinstance(part, LeftAlone):
                yield _last_net(kind, part, real, clock, armed)


def _age(reading: Any, clock: Clock) -> float:
    """How old a reading is; infinite if there is none [s]."""
    return inf if reading is None else float(clock.now() - reading.stamp)


def _last_net(kind: str, part: LeftAlone, real: RealRobot, clock: Clock, armed: bool) -> Finding:
    """What the robot does when commands stop, if it may move to see that."""
    if not armed:
        text = "does it rest without commands? --arm-the-robot moves it by 0.1 m or rad to see"
        return Finding(kind, Verdict.OPEN, text)
    after = _left_alone(kind, part, len(load_robot(real.path).arm.ready), clock)
    text = f"rests after {after:.2f} s"
    if after >= _LEFT:
        text = f"still moves after {_LEFT:g} s: only the driver stops it, not its controller"
    return is_good(kind, after < _LEFT, f"without commands it {text}")


def _left_alone(kind: str, part: Any, joints: int, clock: Clock) -> float:
    """Drive a part slowly for 1 s, then wait: when it rests [s]; inf: not in time.

    Raises HardwareError: it has a fault, or does not follow.
    """
    velocity = np.zeros(3 if kind == "base" else joints)
    velocity[0 if kind == "base" else -1] = _SLOW

    def rests() -> bool:
        reading = part.read()
        return bool(np.abs(reading.twist if kind == "base" else reading.qd).max() < _RESTS)

    for _ in _ticks(clock, 1.0):
        part.read()
        part.send(velocity)
    follows = not rests()
    part.send_last(velocity, _LEFT)
    since = clock.now()
    has_stopped, reading = any(rests() for _ in _ticks(clock, _LEFT)), part.read()
    if reading.faults or not follows:
        why = "; ".join(fault.text for fault in reading.faults)
        raise HardwareError(why or f"it does not follow {_SLOW:g} m/s or rad/s")
    return float(reading.stamp - since) if has_stopped else inf


def _ticks(clock: Clock, seconds: float) -> Iterator[None]:
    """The ticks of a loop on a clock."""
    end = clock.now() + seconds
    while (now := clock.now()) < end:
        yield
        clock.sleep_until(now + PERIOD)


def write_full_scale(real: RealRobot, path: Path) -> None:
    """Write the settings that a base tells to a file, for its options; raises HardwareError."""
    base = parts_of(real, load_robot(real.path), WallClock())["base"]
    if not isinstance(base, TellsItsSite):
        raise HardwareError(f"the base of {real.path.name} does not tell how it drives")
    with _connected(base):
        path.write_text(base.site_text(), encoding="utf-8")


@contextmanager
def _connected(part: Any) -> Iterator[None]:
    part.connect()
    try:
        yield
    finally:
        part.close()
