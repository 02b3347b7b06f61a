"""Driver of the Franka Panda and its hand, each behind a process with the vendor's library."""

from drivers.panda.arm import PandaArm, PandaOptions
from drivers.panda.hand import PandaHand
from drivers.panda.library import LIMITS, JointLimits, missing
from drivers.panda.records import Mode
from drivers.panda.streaming import VelocityLimiter
