"""A real robot from its file: drivers, lock, arming, emulators, and diagnostics."""

from hw.hardware.arming import NotArmedError, check_armed
from hw.hardware.computer import Finding, Verdict, room
from hw.hardware.doctor import examine
from hw.hardware.emulation import emulating
from hw.hardware.lock import CommandedError, RobotLock, commander_of
from hw.hardware.opening import open_hardware
from hw.hardware.parts import write_full_scale
