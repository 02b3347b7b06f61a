"""Diagnostics of computer, robot file and parts, without motion."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees

from hw.hardware import parts
from hw.hardware.arming import is_proven, slowness, speed_note, speed_percent, too_slow
from hw.hardware.computer import computer, installed
from hw.hardware.findings import Finding, Verdict
from hw.hardware.lock import CommandedError, RobotLock
from robots import RealRobot, load_robot

UNSETTLED: tuple[tuple[str, str], ...] = (
    (
        "base: whether a command moves it as fast as it says, and whether it heeds the throttle",
        "`frankie-task doctor --first-metre --arm-the-robot`, along a tape measure; without the "
        "throttle slow motion comes in pulses, or set the dead zones to 0",
    ),
    (
        "base: how old a pose is on arrival",
        "turn on the spot at 30 deg/s and stop: the angle that the pose still turns, by 30 deg/s, "
        "is `pose_delay`",
    ),
    (
        "base: from a command to the velocity (`base_lag`), and its accelerations",
        "`frankie-task delays` on a run that drives and turns",
    ),
    (
        "base: how far it goes when the cable is pulled, and the program killed",
        "both at 0.2 m/s in the open; set `Timeout` to 0.14 s before",
    ),
    (
        "base: how the emergency stop, bumpers and protective fields show",
        "press each at rest, and look at `frankie-task doctor`",
    ),
    (
        "arm: whether `torques` and `forces` fit your hand and camera",
        "push the arm with a spring balance while it stands; wrong masses in Desk look like pushes",
    ),
    (
        "arm: how often commands are late without a real-time kernel",
        "ten minutes at 10 %; `lost` in the readings of the arm, and reflexes for communication",
    ),
    (
        "arm: the lag of its joints (`arm_lag`)",
        "the same, on a run that moves the arm",
    ),
    (
        "hand: whether a grasp and a stop always end, and how wide it says that it is open",
        "close it on nothing, on a block of known width, on something soft; tell it to go to 20 mm "
        "with 40 mm between its fingers: it is stopped after 1.5 s, and holds that",
    ),
    (
        "camera: when an image was captured (`delay`)",
        "turn the wrist at 30 deg/s over an edge: what the edge moves in the world, by 30 deg/s",
    ),
    (
        "both: where the arm stands on the base, and the camera on the hand",
        "`frankie-task calibrate base-arm` and `hand-eye`",
    ),
)
"""What only a real robot can settle: what, and how."""


def examine(real: RealRobot | None) -> Iterator[Finding]:
    """Findings about the computer, and a robot (whose emulators run if it is emulated) if given."""
    yield from installed()
    yield from computer()
    if real is None:
        return
    yield from _file(real)
    try:
        lock = RobotLock(real.hardware).take()
    except CommandedError as error:
        yield Finding("commander", Verdict.BAD, str(error))
        return
    try:
        yield Finding("commander", Verdict.GOOD, "nobody else on this computer commands the robot")
        for part in (parts.base, parts.arm, parts.hand, parts.camera):
            yield from part(real)
    finally:
        lock.release()


def _file(real: RealRobot) -> Iterator[Finding]:
    name = real.path.name
    if real.hardware.emulated is not None:
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
    full = real.hardware.base.scale
    fits = forward <= full.forward + 1e-9 and share * limits.base_reverse <= full.reverse + 1e-9
    hint = "" if fits else "; the base cannot: full_scale is less"
    yield Finding("speed", Verdict.GOOD if fits else Verdict.BAD, text + hint)
    if problem := too_slow(real):
        yield Finding("speed", Verdict.BAD, problem)
    elif slow := slowness(real):
        is_emulated = real.hardware.emulated is not None
        hint = "; dead zones of 0, or `frankie-task doctor --first-metre`, make it go evenly"
        yield Finding("speed", Verdict.GOOD if is_emulated else Verdict.OPEN, slow + hint)
