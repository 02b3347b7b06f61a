"""Emulated RealSense D435: images of a source, over a socket, for the vendor's software device."""

from hw.emulators.realsense.emulator import RealSenseEmulator
from hw.emulators.realsense.options import AS_REPORTED, Options
from hw.emulators.realsense.sources import Shot, of_scene, still
