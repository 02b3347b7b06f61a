"""Emulated Omron LD-60, which shares no code with the driver, so that each checks the other."""

from hw.emulators.omron.controller import Controller, Drive, Motion, Planar, Teleop, Unicycle
from hw.emulators.omron.emulator import OmronEmulator
from hw.emulators.omron.options import AS_REPORTED, EVERYTHING, Options
