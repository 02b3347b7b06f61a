"""Emulated RealSense D435: images of a source, over a socket, for the vendor's software device."""

from extensions.emulators.realsense.emulator import RealSenseEmulator
from extensions.emulators.realsense.options import AS_REPORTED, Options
from extensions.emulators.realsense.sources import Shot, of_scene, still
