"""The whole Frankie, emulated: base, arm, hand and camera over one simulated world, in real time.

`world` is the simulated robot that the emulated parts move, `emulator` the parts together, `words`
what can be done to them, `serving` the port at which that is said and at which images are fetched,
`link` the other end of it.
"""

from hw.emulators.common import PortTakenError
from hw.emulators.frankie.emulator import AS_REPORTED, EmulatedPlaces, FrankieEmulator
from hw.emulators.frankie.link import EmulatorLink, RemoteTruth, SilentEmulatorError
from hw.emulators.frankie.serving import serve
from hw.emulators.frankie.words import WORDS

__all__ = [
    "AS_REPORTED",
    "WORDS",
    "EmulatedPlaces",
    "EmulatorLink",
    "FrankieEmulator",
    "PortTakenError",
    "RemoteTruth",
    "SilentEmulatorError",
    "serve",
]
