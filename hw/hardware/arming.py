"""Whether a real robot may move, and how fast.

A robot moves at a tenth of its speeds until a run with its file has ended without a hardware fault;
from then on at the speed that the file says. A change of the file or calibration begins anew.
"""

import hashlib
import os
from contextlib import suppress
from dataclasses import fields
from math import ceil, degrees
from pathlib import Path

import numpy as np

from config import UserError
from robots import RealRobot, load_robot

FIRST_START = 10.0  # speed of a robot file that was never driven [%]


class NotArmedError(UserError):
    """The user has not armed the robot."""


class TooSlowError(UserError):
    """The base cannot move at the speed of the next run."""


def check_armed(real: RealRobot, armed: bool) -> None:
    """Check that the user has armed a real robot."""
    if real.hardware.emulated is None and not armed:
        raise NotArmedError(
            f"{real.path.name} is a real robot, and it moves only with --arm-the-robot; "
            "first see that nobody is near it and the emergency stop is at hand"
        )


def speed_percent(real: RealRobot) -> float:
    """Speed of the next run, of that of the description [%]."""
    asked = real.hardware.speed_percent
    if real.hardware.emulated is not None or is_proven(real):
        return asked
    return min(asked, max(FIRST_START, least_percent(real)))


def least_percent(real: RealRobot) -> float:
    """Lowest speed at which the base leaves its dead zones, of that of the description [%]."""
    own, limits = real.hardware.base.speeds, load_robot(real.path).limits
    least = np.array([own.least_forward, own.least_reverse, own.least_turn])
    full = np.array([limits.base_twist[0], limits.base_reverse, limits.base_twist[2]])
    return float(ceil(100.0 * (least / full).max() - 1e-6))


def too_slow(real: RealRobot) -> str:
    """Why the base cannot move at the speed of the next run; empty if it can."""
    percent, least = speed_percent(real), least_percent(real)
    if percent >= least:
        return ""
    return (
        f"{real.path.name}: at {percent:g} % of its speeds its base would stand still, for its "
        f"dead zones: the least `speed_percent` is {least:g}; or set them to 0, in MobilePlanner "
        "and in the file"
    )


def speed_note(real: RealRobot) -> str:
    """A note on the speed of the next run; empty for an emulated robot."""
    asked, percent = real.hardware.speed_percent, speed_percent(real)
    if real.hardware.emulated is not None:
        return ""
    note = f"{real.path.name} moves at {percent:g} % of its speeds"
    if percent < asked:
        note = (
            f"{real.path.name} moves for the first time as it is now: at {percent:g} % of its "
            f"speeds; after a run without a fault at the {asked:g} % that it asks for"
        )
    elif asked <= FIRST_START:
        note += "; `speed_percent` in the file says more"
    return "; ".join(filter(None, (note, slowness(real))))


def slowness(real: RealRobot) -> str:
    """A note on commands inside the dead zones of the base; empty where there are none."""
    own = real.hardware.base.speeds
    least = {f"{own.least_forward:.2f} m/s": own.least_forward}
    least |= {f"{degrees(own.least_turn):.1f} deg/s": own.least_turn}
    ends = " or ".join(text for text, one in least.items() if one)
    return f"slower than {ends} its base goes in pulses" if ends else ""


def is_proven(real: RealRobot) -> bool:
    """Whether the robot was driven with this file in its current state."""
    with suppress(OSError):
        return _mark(real).is_file()
    return False


def prove(real: RealRobot) -> None:
    """Record that a run with this file has ended without a hardware fault."""
    with suppress(OSError):  # the next run is slow again
        mark = _mark(real)
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.touch()


def _mark(real: RealRobot) -> Path:
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "frankie-task" / "driven" / _digest(real)


def _digest(real: RealRobot) -> str:
    """Hash of everything that decides how the robot moves, except `speed_percent`."""
    robot = load_robot(real.path)
    limits = [getattr(robot.limits, one.name) for one in fields(robot.limits)]
    mounts = [robot.bTa.homogeneous, robot.camera.eTc.homogeneous]
    numbers = [*limits, *mounts, robot.base.lag, robot.arm.lag, robot.arm.ready]
    digest = hashlib.sha256(real.hardware.model_dump_json(exclude={"speed_percent"}).encode())
    for number in numbers:
        digest.update(np.round(number, 9).tobytes())
    return digest.hexdigest()[:24]
