"""Emulated Omron LD-60: ArNetworking and ARCL over real sockets.

It is written from the protocol notes and shares no code with the driver, so that each checks the
other. `wire` is the wire format, `client` and `arcl_client` one connection each, `requests` what is
offered, `controller` the on-board controller and its interface to a simulated world, `options`
what can be set, go wrong, and behave as reported of real bases, `emulator` the server.
"""

from hw.emulators.omron.controller import Controller, Drive, Motion, Planar, Teleop, Unicycle
from hw.emulators.omron.emulator import OmronEmulator
from hw.emulators.omron.options import AS_REPORTED, EVERYTHING, FAULTS, Options
