"""A real robot from its file: drivers, lock, arming, emulators, and diagnostics."""

from hw.findings import Finding, Verdict
from hw.hardware.arming import NotArmedError, check_armed
from hw.hardware.computer import room
from hw.hardware.diagnostics import examine
from hw.hardware.lock import CommandedError, RobotLock, commander_of
from hw.hardware.opening import open_hardware, open_parts
from hw.hardware.part_diagnostics import write_full_scale
