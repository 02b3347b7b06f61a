"""Driver of the Omron LD-60: motion over ArNetworking; motors and emergency stop over ARCL.

`packet` is the wire format, `handshake` and `connection` open a connection, `telemetry` and
`teleop_settings` decode what the base sends, `site` has settings and converts velocities to ratios,
`commander` decides what is sent, `link` is the thread that sends it, `guardian` the process that
stops the base when that thread cannot. `arcl` is the text interface, `faults` what keeps the base
from moving, `place` where it is, `base` and `laser` the parts of a robot. docs/hardware.md says
what was verified.
"""

from hw.omron.base import OmronBase
from hw.omron.laser import LASER, OmronLaser
from hw.omron.site import ArclSettings, OmronSettings, Site, Velocity
from hw.omron.telemetry import POSE
from hw.omron.teleop_settings import TIMEOUT, Values
