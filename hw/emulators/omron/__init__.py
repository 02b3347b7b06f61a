"""An Omron LD-60 that is not there: ArNetworking and ARCL over real sockets.

It is written from the protocol notes and shares no code with the driver, so that each checks the
other. `wire` are the bytes, `client` and `arcl_client` one connection each, `requests` what is
offered, `controller` the on-board controller, `drive` the seam behind which a world stands,
`options` what can be set and go wrong, `reported` how real ones were reported to behave, and
`emulator` the whole.
"""

from hw.emulators.common import NoFaultError, PortTakenError
from hw.emulators.omron.controller import Motion, Teleop
from hw.emulators.omron.drive import Drive, Unicycle
from hw.emulators.omron.emulator import OmronEmulator
from hw.emulators.omron.options import EVERYTHING, FAULTS, Options
from hw.emulators.omron.reported import AS_REPORTED

__all__ = [
    "AS_REPORTED",
    "EVERYTHING",
    "FAULTS",
    "Drive",
    "Motion",
    "NoFaultError",
    "OmronEmulator",
    "Options",
    "PortTakenError",
    "Teleop",
    "Unicycle",
]
