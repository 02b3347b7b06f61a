"""Emulated Frankie: base, arm, hand and camera over one simulated world, in real time."""

from extensions.emulators.frankie.client import EmulatorLink, RemoteTruth, SilentEmulatorError
from extensions.emulators.frankie.console import WORDS, serve
from extensions.emulators.frankie.emulator import AS_REPORTED, FrankieEmulator
