"""The "Teleop settings" of the base: compared with the robot file, and written for it."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from pathlib import Path

from hw.clock import WallClock
from hw.hardware.drivers import base_of
from hw.hardware.findings import Finding, Verdict
from hw.omron import TIMEOUT, OmronBase, Values
from hw.robot import HardwareError
from robots import RealRobot, load_robot

_SAME = 1e-3  # relative tolerance of values
_TIMEOUTS = 0.1, 0.35
"""Good timeouts: the base checks every 0.1 s; over WLAN commands are up to 0.3 s late [s]."""
_SET = f"set `{TIMEOUT}` to 0.14 s in its Teleop settings (over WLAN 0.3 s)"


def teleop(base: OmronBase, real: RealRobot) -> Iterator[Finding]:
    """What a connected base keeps: its full scale against that of the file, and its `Timeout`."""
    try:
        values = base.read_teleop()
    except HardwareError as error:
        text = f"its Teleop settings cannot be read ({error}): compare `full_scale` by hand"
        yield Finding("base", Verdict.OPEN, f"{text}, and {_SET}")
        return
    yield _full_scale(base, values, real)
    yield _timeout(values.get(TIMEOUT), float(load_robot(real.path).limits.base_twist[0]))


def _full_scale(base: OmronBase, values: Values, real: RealRobot) -> Finding:
    if values.get("FullThrottleForwards") == 0.0:
        text = "its FullThrottleForwards is 0, which stands for its top speed: set a speed there"
        return Finding("base", Verdict.BAD, text)
    kept, says = full_scale_of(base), dict(real.hardware.base.scale)
    for way in ("forward", "reverse"):
        says[f"turn_at_{way}_deg"] = says[f"turn_at_{way}_deg"] or says["turn_deg"]
    wrong = {
        name: value for name, value in kept.items() if abs(says[name] - value) > _SAME * abs(value)
    }
    if not wrong:
        return Finding("base", Verdict.GOOD, "full_scale of the file is what the base tells")
    lines = ", ".join(f"{name}: {value:.4g}" for name, value in wrong.items())
    text = f"the base tells otherwise; write below full_scale: {lines}"
    return Finding("base", Verdict.BAD, text)


def _timeout(value: float | str | None, speed: float) -> Finding:
    """Check the base's own `Timeout` [s] at the top speed of the robot [m/s]."""
    if not isinstance(value, float):
        return Finding("base", Verdict.OPEN, f"it does not tell its own `{TIMEOUT}`: {_SET}")
    least, most = _TIMEOUTS
    says = f"its own `{TIMEOUT}` is {value:g} s: "
    if value == 0.0:
        return Finding("base", Verdict.BAD, f"{says}with the cable pulled it never stops; {_SET}")
    if value < least:
        return Finding("base", Verdict.BAD, f"{says}it stops between two commands; {_SET}")
    way = f"with the cable pulled it drives on for {speed * value:.2f} m at {speed:g} m/s"
    if value > most:
        return Finding("base", Verdict.BAD, f"{says}{way}; {_SET}")
    return Finding("base", Verdict.GOOD, f"{says}{way}, then brakes")


def full_scale_of(base: OmronBase) -> dict[str, float]:
    """Full-scale values of a connected base, by the keys of `full_scale` in a robot file.

    Raises:
        HardwareError: they cannot be read.
    """
    site = base.read_site()
    forward, reverse = site.turn_at_forward, site.turn_at_reverse
    return {
        "forward": site.forward,
        "reverse": site.reverse,
        "turn_deg": degrees(site.turn),
        "turn_at_forward_deg": degrees(site.turn if forward is None else forward),
        "turn_at_reverse_deg": degrees(site.turn if reverse is None else reverse),
        "dead_translation": site.dead_translation,
        "dead_rotation": site.dead_rotation,
    }


def write_full_scale(real: RealRobot, path: Path, *, throttle: bool) -> None:
    """Write the full-scale values of a base to a file, for `full_scale: FILE`."""
    base = base_of(real.hardware, load_robot(real.path).limits, WallClock())
    base.connect()
    try:
        kept = full_scale_of(base)
    finally:
        base.close()
    lines = [f"# As the base at {real.hardware.base.address} tells; m/s, deg/s and %."]
    lines += [f"{name}: {round(value, 4)}" for name, value in kept.items()]
    lines += [f"throttle: {str(throttle).lower()}"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
