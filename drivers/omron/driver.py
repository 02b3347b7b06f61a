"""The drivers of an Omron LD-60: its base, and its laser over the same connection."""

from drivers.omron.base import OmronBase
from drivers.omron.base_options import OmronOptions
from drivers.omron.laser import OmronLaser
from hw import DriverContext, HardwareError
from robots import DriverOptions


def omron_base(options: OmronOptions, context: DriverContext) -> OmronBase:
    """The driver of the base."""
    straight, _, turning = context.robot.limits.base_acceleration.tolist()
    return OmronBase(options, context.clock, (straight, turning))


def omron_laser(options: DriverOptions, context: DriverContext) -> OmronLaser:
    """The driver of the laser."""
    drive, mount = context.parts["base"], context.robot.laser
    if not isinstance(drive, OmronBase) or mount is None:
        raise HardwareError("the laser of an Omron base needs that base, and a mount in its robot")
    return OmronLaser(lambda: drive.echoes, mount, context.clock)
