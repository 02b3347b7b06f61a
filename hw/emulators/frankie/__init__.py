"""Emulated Frankie: base, arm, hand and camera over one simulated world, in real time."""

from hw.emulators.frankie.console import WORDS, serve
from hw.emulators.frankie.emulator import AS_REPORTED, FrankieEmulator
from hw.emulators.frankie.link import EmulatorLink, RemoteTruth, SilentEmulatorError
