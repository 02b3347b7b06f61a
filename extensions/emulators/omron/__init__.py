"""Emulated Omron LD-60, which shares no code with the driver, so that each checks the other."""

from extensions.emulators.omron.emulator import OmronEmulator
from extensions.emulators.omron.onboard_controller import Controller, Teleop, Unicycle
from extensions.emulators.omron.options import AS_REPORTED, EVERYTHING, Options
