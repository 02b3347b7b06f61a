"""A Franka Panda below `hardware` in a robot file: the drivers of its arm and hand."""

from drivers.panda.arm import PandaArm, PandaOptions
from drivers.panda.hand import HandOptions, PandaHand
from hw import DriverContext, HardwareError


def panda_arm(options: PandaOptions, context: DriverContext) -> PandaArm:
    """The driver of the arm."""
    return PandaArm(options.address, context.clock, options)


def franka_hand(options: HandOptions, context: DriverContext) -> PandaHand:
    """The driver of the hand."""
    arm = context.parts.get("arm")
    address = options.address or (arm.address if isinstance(arm, PandaArm) else None)
    if address is None:
        raise HardwareError("gripper: `address` is missing, and the arm is no Panda, which has one")
    return PandaHand(address, context.clock, options.speed)
