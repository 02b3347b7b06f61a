"""The Omron LD-60 over the network: ArNetworking for motion, ARCL for motors and emergency stop.

`packet` and `fields` are the bytes; `handshake`, `connection` and `first_readings` how it begins;
`telemetry` and `config` what the base tells; `site` what a velocity is to it; `commander` what is
written when; `link` the thread that does it; `guardian` the process that stops the base when that
thread cannot; `arcl` the text interface; `faults` what keeps the base from moving; and `base` the
whole as a `Base`.
docs/hardware.md says what of all this was verified, and what is inferred.
"""

from hw.omron.arcl import Arcl
from hw.omron.arcl_text import ArclState, Motors
from hw.omron.base import OmronBase
from hw.omron.config import TIMEOUT, Values
from hw.omron.handshake import PROTOCOLS, Catalogue
from hw.omron.settings import ArclSettings, OmronSettings
from hw.omron.site import Site, Velocity

__all__ = [
    "PROTOCOLS",
    "TIMEOUT",
    "Arcl",
    "ArclSettings",
    "ArclState",
    "Catalogue",
    "Motors",
    "OmronBase",
    "OmronSettings",
    "Site",
    "Values",
    "Velocity",
]
