"""Driver of the Omron LD-60: motion over ArNetworking; motors and emergency stop over ARCL."""

from hw.omron.base import OmronBase
from hw.omron.base_options import ArclOptions, OmronOptions
from hw.omron.laser import OmronLaser
from hw.omron.site import Site
