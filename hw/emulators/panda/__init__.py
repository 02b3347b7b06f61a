"""A Franka Panda with its hand, as seen over the network.

Interface version 5 of the arm and 3 of the hand, over TCP and UDP on the ports of the real one;
`serve` runs it, and `AS_REPORTED` is how real ones were reported to behave. The bodies behind it
are `Joints` and `Fingers`: a simulated world can take their place. `ACTIONS` is what can be done to
it while it runs.
"""

from hw.emulators.common import PortTakenError
from hw.emulators.panda.arm import EmulatedArm, Seen
from hw.emulators.panda.console import ACTIONS
from hw.emulators.panda.hand import EmulatedHand
from hw.emulators.panda.linked import ArmLink, Wanted
from hw.emulators.panda.parts import Fingers, FreeFingers, Joints, LaggedJoints
from hw.emulators.panda.reported import AS_REPORTED
from hw.emulators.panda.serving import serve
from hw.emulators.panda.wire import MotionCommand

__all__ = [
    "ACTIONS",
    "AS_REPORTED",
    "ArmLink",
    "EmulatedArm",
    "EmulatedHand",
    "Fingers",
    "FreeFingers",
    "Joints",
    "LaggedJoints",
    "MotionCommand",
    "PortTakenError",
    "Seen",
    "Wanted",
    "serve",
]
