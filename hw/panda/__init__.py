"""The driver of the Franka Panda and its hand.

`PandaArm` and `PandaHand` are parts of a robot. Behind each stands a process of its own with the
vendor's library: `arm_process` with its loop at 1 kHz in `streaming` and `limiter`, and
`hand_process`. `generation` says what is true of a Panda, and is the seam for an FR3.
"""

from hw.panda.arm import ArmSettings, PandaArm
from hw.panda.generation import PANDA, Generation, JointLimits, missing
from hw.panda.hand import HandSettings, PandaHand
from hw.panda.limiter import VelocityLimiter
from hw.panda.records import ArmReading, HandReading, Mode

__all__ = [
    "PANDA",
    "ArmReading",
    "ArmSettings",
    "Generation",
    "HandReading",
    "HandSettings",
    "JointLimits",
    "Mode",
    "PandaArm",
    "PandaHand",
    "VelocityLimiter",
    "missing",
]
