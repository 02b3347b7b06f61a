"""Diagnostics of the parts of a robot: each is connected, read and closed."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import degrees, inf, isfinite
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from hw.clock import Clock, WallClock, stopwatch
from hw.hardware.computer import Finding, Verdict, is_good
from hw.omron import LASER, POSE, TIMEOUT, OmronBase, OmronLaser, OmronOptions, Values
from hw.panda import INTERFACE_VERSION, PandaArm, PandaHand
from hw.real_parts import parts_of
from hw.realsense import RealSenseCamera, RealSenseOptions
from hw.robot import HardwareError, LeftAlone, Part
from robots import DriverOptions, RealRobot, load_robot

_LOOKS, _PERIOD = 200, 0.01  # number of readings of a part, and their period [s]
_FIRST = 500  # periods in which the first image or scan comes
_OLD_POSE, _OLD_STATE, _OLD_IMAGE, _OLD_SCAN = 150.0, 50.0, 100.0, 300.0  # largest ages [ms]
_SAME = 1e-3  # relative tolerance of full-scale values
_TIMEOUTS = 0.1, 0.35  # good ones: the base checks every 0.1 s, and WLAN is 0.3 s late [s]
_SET = f"set `{TIMEOUT}` to 0.14 s in its Teleop settings (over WLAN 0.3 s)"

_LEFT = 1.0  # a robot is left alone for so long at most [s] ...
_SLOW, _RESTS = 0.05, 0.01  # ... at this speed; below the other one it rests [m/s, rad/s]

Read = TypeVar("Read")


def findings_of(
    kind: str, part: Any, real: RealRobot, clock: Clock, *, armed: bool = False
) -> Iterator[Finding]:
    """Faults, battery and age of the readings of one part, and what else its driver tells."""
    if isinstance(part, OmronLaser):
        return  # over the connection of the base, which tells of it
    with _connected(part):
        faults = part.read().faults if hasattr(part, "read") else getattr(part, "faults", tuple)()
        yield from (Finding(kind, Verdict.BAD, fault.text) for fault in faults)
        if isinstance(part, OmronBase):
            yield from _omron(part, real)
        elif isinstance(part, PandaArm):
            yield from _panda(part, "" if faults else ", ready to move")
        elif isinstance(part, PandaHand):
            yield from _hand(part)
        elif isinstance(part, RealSenseCamera):
            yield from _realsense(part, real.hardware.camera)
        else:
            newest, oldest = getattr(part, "read", None), _OLD_POSE
            if newest is None:
                newest, oldest = part.latest, _OLD_SCAN
            for _ in range(_FIRST):
                if newest() is not None:
                    break
                time.sleep(_PERIOD)
            yield _ages(kind, "readings", lambda: _age(newest(), clock), oldest)
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
        clock.sleep_until(now + _PERIOD)


def _omron(base: OmronBase, real: RealRobot) -> Iterator[Finding]:
    """Protocol, localisation, battery, age of poses, settings."""
    file = real.hardware.base
    assert isinstance(file, OmronOptions)
    yield Finding("base", Verdict.GOOD, f"ArNetworking {base.protocol}, everything is offered")
    if file.arcl is None:
        text = "no ARCL in the file: nobody tells that the emergency stop is pressed"
        yield Finding("base", Verdict.BAD, text)
    if (battery := base.read().battery) is not None:
        yield is_good("base", battery > 0.2, f"battery {100.0 * battery:.0f} %")
    yield from _localisation(base)
    yield _ages("base", "poses", lambda: base.pose_age, _OLD_POSE)
    yield from _teleop(base, file, float(load_robot(real.path).limits.base_twist[0]))


def _localisation(base: OmronBase) -> Iterator[Finding]:
    """What the base tells of its place, and how its localised pose varies while it stands."""
    seen = _watched(lambda: base.read().localised)
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


def write_full_scale(real: RealRobot, path: Path) -> None:
    """Write the full-scale values of a base to a file, for `full_scale: FILE`."""
    base, file = parts_of(real, load_robot(real.path), WallClock())["base"], real.hardware.base
    if not isinstance(base, OmronBase) or not isinstance(file, OmronOptions):
        raise HardwareError(f"{real.path.name} has no Omron base, which alone tells its full scale")
    with _connected(base):
        kept = base.read_site().values
    lines = [f"# As the base at {file.address} tells; m/s, deg/s and %."]
    lines += [f"{name}: {round(value, 4)}" for name, value in kept.items()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _panda(arm: PandaArm, ready: str) -> Iterator[Finding]:
    """Protocol, masses, age of states."""
    yield Finding("arm", Verdict.GOOD, f"interface version {INTERFACE_VERSION}{ready}")
    reading = arm.reading()
    text = (
        f"Desk says that the hand weighs {reading.hand_mass:.2f} kg and carries "
        f"{reading.load:.2f} kg: the camera and its mount count, too"
    )
    yield Finding("arm", Verdict.OPEN, text)
    yield _ages("arm", "states", lambda: stopwatch() - arm.reading().stamp, _OLD_STATE)


def _hand(hand: PandaHand) -> Iterator[Finding]:
    """Width and temperature, once it was homed."""
    if (reading := hand.reading()).is_homed:
        text = f"{1000.0 * reading.width:.0f} mm open, {reading.temperature} degrees C"
        yield Finding("gripper", Verdict.GOOD, text)


def _realsense(camera: RealSenseCamera, file: DriverOptions) -> Iterator[Finding]:
    """Model, firmware, frame rate, age of images."""
    assert isinstance(file, RealSenseOptions)
    before = camera.report()
    time.sleep(_LOOKS * _PERIOD)
    report = camera.report()
    status = report.status
    usb = f", USB {status.usb}" if status.usb else ""
    firmware = f", firmware {status.firmware}" if status.firmware else ""
    yield Finding("camera", Verdict.GOOD, f"{status.name} {status.serial}{firmware}{usb}")
    if status.usb and not status.usb.startswith("3"):
        text = "it is connected by USB 2: use a cable and a port of USB 3"
        yield Finding("camera", Verdict.BAD, text)
    if _version(status.firmware) < _version(status.recommended):
        text = f"the library is made for firmware {status.recommended} or newer: rs-fw-update"
        yield Finding("camera", Verdict.OPEN, text)
    rate = (report.images - before.images) / (_LOOKS * _PERIOD)
    lost, age = report.lost - before.lost, 1000.0 * report.age
    good = rate > 0.8 * file.rate and age < _OLD_IMAGE
    text = f"{rate:.0f} images/s, {lost} lost, {age:.0f} ms old on arrival"
    yield is_good("camera", good, text)


def _ages(about: str, what: str, age: Callable[[], float], most: float) -> Finding:
    """How old readings are [s], and whether they are younger than `most` [ms]."""
    ages = [1000.0 * one for one in _watched(age)]
    text = f"{what} are {np.median(ages):.0f} ms old in the middle, {max(ages):.0f} ms at worst"
    if not isfinite(max(ages)):
        text = f"there are no {what} within {_FIRST * _PERIOD:g} s, or not always"
    return is_good(about, max(ages) < most, text)


def _watched(read: Callable[[], Read]) -> list[Read]:
    seen = []
    for _ in range(_LOOKS):
        seen.append(read())
        time.sleep(_PERIOD)
    return seen


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(".") if part.isdigit())


@contextmanager
def _connected(part: Part) -> Iterator[None]:
    part.connect()
    try:
        yield
    finally:
        part.close()
