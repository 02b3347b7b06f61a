"""What the diagnostics tell of an LD-60: where it takes itself to be, and how it is set up."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from drivers.omron.base_options import OmronOptions
from drivers.omron.laser import LASER
from drivers.omron.telemetry import POSE
from drivers.omron.teleop_settings import TIMEOUT, Values
from hw import Finding, HardwareError, Verdict, ages, is_good, watched

if TYPE_CHECKING:
    from drivers.omron.base import OmronBase

_OLD_POSE = 150.0  # largest age [ms]
_SAME = 1e-3  # relative tolerance of full-scale values
_TIMEOUTS = 0.1, 0.35  # good ones: the base checks every 0.1 s, and WLAN is 0.3 s late [s]
_SET = f"set `{TIMEOUT}` to 0.14 s in its Teleop settings (over WLAN 0.3 s)"


def examine(base: OmronBase, file: OmronOptions, speed: float) -> Iterator[Finding]:
    """Protocol, localisation, battery, age of poses, settings; at a top speed [m/s]."""
    yield Finding("base", Verdict.GOOD, f"ArNetworking {base.protocol}, everything is offered")
    if file.arcl is None:
        text = "no ARCL in the file: nobody tells that the emergency stop is pressed"
        yield Finding("base", Verdict.BAD, text)
    if (battery := base.read().battery) is not None:
        yield is_good("base", battery > 0.2, f"battery {100.0 * battery:.0f} %")
    yield from _localisation(base)
    yield ages("base", "poses", lambda: base.pose_age, _OLD_POSE)
    yield from _teleop(base, file, speed)


def _localisation(base: OmronBase) -> Iterator[Finding]:
    """What the base tells of its place, and how its localised pose varies while it stands."""
    seen = watched(lambda: base.read().localised)
    has, score, echoes = base.catalogue.has, base.link.score, base.echoes
    points = 0 if echoes is None else len(echoes.points)
    tells: tuple[tuple[str, str | None, str], ...] = (
        (
            "odometry",
            "of its encoders" if base.link.telemetry.has_encoders else None,
            "the integral of its velocity is used, which comes in whole mm/s and deg/s",
        ),
        (
            "fine poses",
            "to less than a millimetre" if has(*POSE) else None,
            "they come in whole millimetres and degrees",
        ),
        (
            "localisation score",
            None if score is None else f"{score:.2f}",
            "a poor localisation looks like a good one",
        ),
        (
            "scans of its laser",
            f"{points} points in the last one" if has(LASER) else None,
            "only the camera corrects where it believes to be",
        ),
    )
    for what, value, without in tells:
        text = f"no {what}: {without}" if value is None else f"{what}: {value}"
        yield Finding("base", Verdict.OPEN if value is None else Verdict.GOOD, text)
    poses = {id(one): one.mTb for one in seen if one is not None}.values()
    if poses:
        x, y = np.transpose([pose.translation[:2] for pose in poses])
        first = next(iter(poses)).rotation
        turns = [pin.log3(first.T @ pose.rotation)[2] for pose in poses]
        heading = degrees(pin.log3(first)[2] + np.mean(turns))
        spread = 1000.0 * np.hypot(np.std(x), np.std(y))
        text = (
            f"localised at x {np.mean(x):.3f} m, y {np.mean(y):.3f} m, {heading:.2f} deg; "
            f"at rest that varies by {spread:.1f} mm and {degrees(np.std(turns)):.2f} deg"
        )
        yield Finding("base", Verdict.GOOD, text)


def _teleop(base: OmronBase, file: OmronOptions, speed: float) -> Iterator[Finding]:
    try:
        values = base.read_teleop()
    except HardwareError as error:
        text = f"its Teleop settings cannot be read ({error}): compare `full_scale` by hand"
        yield Finding("base", Verdict.OPEN, f"{text}, and {_SET}")
        return
    yield _full_scale(base, values, file)
    yield _timeout(values.get(TIMEOUT), speed)


def _full_scale(base: OmronBase, values: Values, file: OmronOptions) -> Finding:
    if values.get("FullThrottleForwards") == 0.0:
        text = "its FullThrottleForwards is 0, which stands for its top speed: set a speed there"
        return Finding("base", Verdict.BAD, text)
    kept, says = base.read_site().values, file.site.values
    lines = ", ".join(
        f"{name}: {value:.4g}"
        for name, value in kept.items()
        if abs(says[name] - value) > _SAME * abs(value)
    )
    if not lines:
        return Finding("base", Verdict.GOOD, "full_scale of the file is what the base tells")
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
    return is_good("base", value <= most, f"{says}{way}; {_SET if value > most else 'then brakes'}")
