"""Driver of the Franka Panda and its hand.

`PandaArm` and `PandaHand` are parts of a robot. Behind each is a process of its own with the
vendor's library: `arm_process`, with its 1 kHz loop in `streaming`, and `hand_process`.
"""

from hw.panda.arm import ArmSettings, PandaArm
from hw.panda.hand import PandaHand
from hw.panda.library import INTERFACE_VERSION, LIMITS, JointLimits, missing
from hw.panda.records import Mode
from hw.panda.streaming import VelocityLimiter
