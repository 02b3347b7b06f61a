"""A real robot, made of its drivers as its file says: who may command it, how fast, and with what.

`drivers` makes the parts, `lock` lets one program command it, `arming` says who may move it and how
fast, `emulation` starts the emulators of a robot that is not there, `opening` puts all together.
"""

from hw.hardware.arming import NotArmedError, check_armed
from hw.hardware.drivers import arm_of, base_of, camera_of
from hw.hardware.lock import CommandedError, RobotLock, commander_of
from hw.hardware.opening import open_hardware

__all__ = [
    "CommandedError",
    "NotArmedError",
    "RobotLock",
    "arm_of",
    "base_of",
    "camera_of",
    "check_armed",
    "commander_of",
    "open_hardware",
]
