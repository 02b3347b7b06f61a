"""Diagnostics of computer, robot file and parts, without motion unless the robot is armed."""

from collections.abc import Iterator
from math import degrees

from hw.clock import WallClock
from hw.findings import Finding, Verdict, is_good
from hw.hardware.arming import is_proven, slowness, speed_note, speed_percent, too_slow
from hw.hardware.computer import computer, room
from hw.hardware.lock import CommandedError, RobotLock
from hw.hardware.part_diagnostics import findings_of
from hw.real_parts import one_line, parts_of
from hw.robot import HardwareError
from robots import KINDS, RealRobot, load_robot


def examine(real: RealRobot | None, *, armed: bool = False) -> Iterator[Finding]:
    """Findings about the computer, and a robot (with its emulators) if given; armed it may move."""
    if real is None:
        yield from computer()
        yield from room(load_robot("frankie"))
        return
    used = (getattr(real.hardware, kind) for kind in KINDS)
    yield from computer({one.driver for one in used if one})
    yield from room(load_robot(real.path))
    yield from _file(real)
    try:
        lock = RobotLock(real.hardware).take()
    except CommandedError as error:
        yield Finding("commander", Verdict.BAD, str(error))
        return
    try:
        yield Finding("commander", Verdict.GOOD, "nobody else on this computer commands the robot")
        clock = WallClock()
        try:
            parts = parts_of(real, load_robot(real.path), clock)
        except HardwareError as error:
            yield Finding("drivers", Verdict.BAD, str(error))
            return
        for kind, part in parts.items():
            try:
                yield from findings_of(kind, part, real, clock, armed=armed)
            except (Exception, SystemExit) as error:  # whatever somebody's driver raises
                known = isinstance(error, HardwareError) and str(error)
                yield Finding(kind, Verdict.BAD, known or f"it raises {one_line(error)}")
    finally:
        lock.release()


def _file(real: RealRobot) -> Iterator[Finding]:
    name, is_emulated = real.path.name, real.hardware.emulated is not None
    if is_emulated:
        yield Finding("file", Verdict.GOOD, f"{name}: an emulated robot")
    else:
        driven = "was driven" if is_proven(real) else "was never driven as it is now"
        text = f"{name} {driven}; {speed_note(real)}"
        yield Finding("file", Verdict.GOOD if is_proven(real) else Verdict.OPEN, text)
    for mount, command in (("camera_mount", "hand-eye"), ("arm_mount", "base-arm")):
        if mount in real.calibrated:
            yield Finding("calibration", Verdict.GOOD, f"{mount} is that of this robot")
        else:
            text = f"{mount} is that of the description; frankie-task calibrate {command}"
            yield Finding("calibration", Verdict.OPEN, text)
    limits = load_robot(real.path).limits
    share = speed_percent(real) / 100.0
    forward, _, turn = share * limits.base_twist
    text = (
        f"at {100.0 * share:g} % of its speeds: {forward:.2f} m/s, {degrees(turn):.0f} deg/s, "
        f"brakes at {limits.base_acceleration[0]:g} m/s^2"
    )
    full = real.hardware.base.speeds
    fits = forward <= full.forward + 1e-9 and share * limits.base_reverse <= full.reverse + 1e-9
    yield is_good("speed", fits, text + ("" if fits else "; the base cannot: full_scale is less"))
    if problem := too_slow(real):
        yield Finding("speed", Verdict.BAD, problem)
    elif slow := slowness(real):
        verdict = Verdict.GOOD if is_emulated else Verdict.OPEN
        yield Finding("speed", verdict, f"{slow}; dead zones of 0 make it go evenly")
