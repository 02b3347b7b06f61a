"""Driver of the Franka Panda and its hand, each behind a process with the vendor's library."""

from hw.panda.arm import PandaArm, PandaOptions
from hw.panda.hand import PandaHand
from hw.panda.library import LIMITS, JointLimits, missing
from hw.panda.records import Mode
from hw.panda.streaming import VelocityLimiter
