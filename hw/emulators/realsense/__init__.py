"""A RealSense D435 that is not there: images from a source, over a socket, to the driver.

The vendor has no protocol that a server could speak: a camera hangs on USB. What stands in for it
is a software device of the vendor's library, which lives in the process that uses it. So this
emulator sends images, and the driver feeds such a device with them; pipeline, formats, filters and
intrinsics are then the vendor's, and firmware, cable and exposure are not there. `emulator` is the
whole, `sources` where images come from, `options` what can be set and go wrong, `reported` how real
cameras were reported to behave.
"""

from hw.emulators.errors import NoFaultError, PortTakenError
from hw.emulators.realsense.emulator import RealSenseEmulator
from hw.emulators.realsense.options import FAULTS, Options
from hw.emulators.realsense.reported import AS_REPORTED
from hw.emulators.realsense.sources import Shot, Source, of_camera, of_scene, still

__all__ = [
    "AS_REPORTED",
    "FAULTS",
    "NoFaultError",
    "Options",
    "PortTakenError",
    "RealSenseEmulator",
    "Shot",
    "Source",
    "of_camera",
    "of_scene",
    "still",
]
