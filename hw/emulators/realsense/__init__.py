"""Emulated RealSense D435: sends images of a source over a socket to the driver.

A USB camera has no network protocol to emulate. The driver feeds a software device of the vendor's
library with the images: pipeline, formats and intrinsics are the vendor's; firmware, cable and
exposure are not emulated. `emulator` is the server, `sources` where images come from, `options`
what can be set, go wrong, and behave as reported of real cameras.
"""

from hw.emulators.realsense.emulator import RealSenseEmulator
from hw.emulators.realsense.options import AS_REPORTED, FAULTS, Options
from hw.emulators.realsense.sources import Shot, of_scene, still
