"""Diagnostics of the parts of a robot: each is connected, read and closed; nothing moves."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import TypeVar

import numpy as np

from hw.clock import WallClock, stopwatch
from hw.hardware.drivers import arm_of, base_of, camera_of, hand_of
from hw.hardware.findings import Finding, Verdict
from hw.hardware.teleop import teleop
from hw.omron import OmronBase
from hw.panda import INTERFACE_VERSION, PandaArm, PandaHand
from hw.realsense import RealSenseCamera
from hw.robot import HardwareError
from robots import RealRobot, load_robot

_LOOKS, _PERIOD = 200, 0.01  # number of readings of a part, and their period [s]
_ARM_PORT, _HAND_PORT = 1337, 1338
_TRIES, _PAUSE = 5, 0.05  # number of connections that measure a line, and the time between them [s]
_OLD_POSE, _OLD_STATE, _OLD_IMAGE = 150.0, 50.0, 100.0  # largest ages of readings [ms]


def base(real: RealRobot) -> Iterator[Finding]:
    """Line, protocol, faults, localisation, battery, age of poses, settings."""
    hardware = real.hardware
    yield _line("base", hardware.base.address, hardware.base.port)
    drive = base_of(hardware, load_robot(real.path).limits, WallClock())
    with _connected("base", drive) as error:
        if error is not None:
            yield error
            return
        yield Finding("base", Verdict.GOOD, f"ArNetworking {drive.protocol}, everything is offered")
        if hardware.base.arcl is None:
            text = "no ARCL in the file: nobody tells that the emergency stop is pressed"
            yield Finding("base", Verdict.BAD, text)
        faults = [fault.text for fault in drive.read().faults]
        yield from (Finding("base", Verdict.BAD, text) for text in faults)
        score, battery = drive.localisation_score, drive.read().battery
        if score is not None:
            yield Finding("base", Verdict.GOOD, f"localisation score {score:.2f}")
        if battery is not None:
            low = Verdict.GOOD if battery > 0.2 else Verdict.BAD
            yield Finding("base", low, f"battery {100.0 * battery:.0f} %")
        yield from _poses(drive)
        yield from teleop(drive, real)


def _poses(base: OmronBase) -> Iterator[Finding]:
    ages = []
    for _ in range(_LOOKS):
        ages.append(1000.0 * base.pose_age)
        time.sleep(_PERIOD)
    text = f"poses are {np.median(ages):.0f} ms old in the middle, {max(ages):.0f} ms at worst"
    yield Finding("base", Verdict.GOOD if max(ages) < _OLD_POSE else Verdict.BAD, text)


def arm(real: RealRobot) -> Iterator[Finding]:
    """Protocol, faults, masses, age of states, line."""
    hardware = real.hardware
    driver = arm_of(hardware, WallClock())
    with _connected("arm", driver) as error:
        if error is not None:
            yield error
            return
        faults = driver.read().faults
        ready = "" if faults else ", ready to move"
        yield Finding("arm", Verdict.GOOD, f"interface version {INTERFACE_VERSION}{ready}")
        yield from (Finding("arm", Verdict.BAD, fault.text) for fault in faults)
        reading = driver.reading()
        text = (
            f"Desk says that the hand weighs {reading.hand_mass:.2f} kg and carries "
            f"{reading.load:.2f} kg: the camera and its mount count, too"
        )
        yield Finding("arm", Verdict.OPEN, text)
        yield from _states(driver)
    yield _line("arm", hardware.arm.address, _ARM_PORT)


def _states(arm: PandaArm) -> Iterator[Finding]:
    ages, times = [], []
    for _ in range(_LOOKS):
        reading = arm.reading()
        ages.append(1000.0 * (stopwatch() - reading.stamp))
        times.append(reading.time)
        time.sleep(_PERIOD)
    gaps = [b - a for a, b in pairwise(times)]
    text = (
        f"states are {np.median(ages):.1f} ms old in the middle, {max(ages):.1f} ms at worst; "
        f"at most {max(gaps)} ms of its clock between two looks"
    )
    yield Finding("arm", Verdict.GOOD if max(ages) < _OLD_STATE else Verdict.BAD, text)


def hand(real: RealRobot) -> Iterator[Finding]:
    """Width, temperature, whether it was homed, line."""
    fingers = hand_of(real.hardware, WallClock())
    with _connected("hand", fingers) as error:
        if error is not None:
            yield error
            return
        yield from (Finding("hand", Verdict.BAD, fault.text) for fault in fingers.read().faults)
        reading = fingers.reading()
        if reading.is_homed:
            text = f"{1000.0 * reading.width:.0f} mm open, {reading.temperature} degrees C"
            yield Finding("hand", Verdict.GOOD, text)
    yield _line("hand", real.hardware.arm.address, _HAND_PORT)


def camera(real: RealRobot) -> Iterator[Finding]:
    """Model, firmware, frame rate, age of images."""
    description = load_robot(real.path).camera
    eye = camera_of(real.hardware, description, WallClock())
    with _connected("camera", eye) as error:
        if error is not None:
            yield error
            return
        before = eye.report()
        time.sleep(_LOOKS * _PERIOD)
        report = eye.report()
        status, images = report.status, report.images - before.images
        lost = report.lost - before.lost
        usb = f", USB {status.usb}" if status.usb else ""
        firmware = f", firmware {status.firmware}" if status.firmware else ""
        yield Finding("camera", Verdict.GOOD, f"{status.name} {status.serial}{firmware}{usb}")
        if status.usb and not status.usb.startswith("3"):
            text = "it is connected by USB 2: use a cable and a port of USB 3"
            yield Finding("camera", Verdict.BAD, text)
        if _version(status.firmware) < _version(status.recommended):
            text = f"the library is made for firmware {status.recommended} or newer: rs-fw-update"
            yield Finding("camera", Verdict.OPEN, text)
        rate = images / (_LOOKS * _PERIOD)
        text = f"{rate:.0f} images/s, {lost} lost, {1000.0 * report.age:.0f} ms old on arrival"
        good = rate > 0.8 * real.hardware.camera.rate and 1000.0 * report.age < _OLD_IMAGE
        yield Finding("camera", Verdict.GOOD if good else Verdict.BAD, text)


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(".") if part.isdigit())


def _line(what: str, address: str, port: int) -> Finding:
    """Round-trip time of connections."""
    took, failed = [], ""
    for _ in range(_TRIES):
        time.sleep(_PAUSE)
        begun = stopwatch()
        try:
            socket.create_connection((address, port), 1.0).close()
        except OSError as error:
            failed = error.strerror or str(error)
            continue
        took.append(1000.0 * (stopwatch() - begun))
    if not took:
        return Finding(what, Verdict.BAD, f"{address}:{port} does not answer: {failed}")
    lost = _TRIES - len(took)
    text = f"{address}:{port}: {np.median(took):.2f} ms there and back, {max(took):.1f} ms at worst"
    good = not lost and max(took) < 100.0
    text += f", {lost} of {_TRIES} lost" if lost else ""
    return Finding(what, Verdict.GOOD if good else Verdict.BAD, text)


Part = TypeVar("Part", OmronBase, PandaArm, PandaHand, RealSenseCamera)


@contextmanager
def _connected(what: str, part: Part) -> Iterator[Finding | None]:
    """Connect and close a part; a finding if that fails."""
    try:
        part.connect()
    except HardwareError as error:
        yield Finding(what, Verdict.BAD, str(error))
        return
    try:
        yield None
    finally:
        part.close()
