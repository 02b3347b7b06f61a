"""A real robot, made of its drivers as its file says: who may command it, how fast, and with what.

`drivers` makes the parts, `lock` lets one program command it, `arming` says who may move it and how
fast, `emulation` starts the emulators of a robot that is not there, `opening` puts all together.
`doctor` looks at `computer`, file, `parts` and `teleop` without moving anything; `first_metre` is a
person's first drive; `unsettled` is what is left.
"""

from hw.hardware.arming import NotArmedError, check_armed
from hw.hardware.doctor import examine
from hw.hardware.drivers import arm_of, base_of, camera_of
from hw.hardware.emulation import emulating
from hw.hardware.findings import Finding, Verdict
from hw.hardware.first_metre import first_metre
from hw.hardware.lock import CommandedError, RobotLock, commander_of
from hw.hardware.opening import open_hardware
from hw.hardware.teleop import write_full_scale
from hw.hardware.unsettled import UNSETTLED

__all__ = [
    "UNSETTLED",
    "CommandedError",
    "Finding",
    "NotArmedError",
    "RobotLock",
    "Verdict",
    "arm_of",
    "base_of",
    "camera_of",
    "check_armed",
    "commander_of",
    "emulating",
    "examine",
    "first_metre",
    "open_hardware",
    "write_full_scale",
]
