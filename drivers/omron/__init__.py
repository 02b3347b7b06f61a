"""Driver of the Omron LD-60: motion over ArNetworking; motors and emergency stop over ARCL."""

from drivers.omron.base import OmronBase
from drivers.omron.base_options import ArclOptions, OmronOptions
from drivers.omron.laser import OmronLaser
from drivers.omron.site import Site
