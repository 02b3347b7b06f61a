"""The robot: one interface, and the robots behind it.

`interfaces` says what a robot is, `clock` where time comes from, `gate` what may reach it. `sim` is
the kinematic simulator; drivers of real hardware stand beside it. A task never knows which it got.
"""

from hw.clock import Clock, SimClock, WallClock, stopwatch
from hw.interfaces import (
    HAND_OPENING,
    DepthFrame,
    Fault,
    FaultKind,
    HardwareError,
    Robot,
    RobotState,
)

__all__ = [
    "HAND_OPENING",
    "Clock",
    "DepthFrame",
    "Fault",
    "FaultKind",
    "HardwareError",
    "Robot",
    "RobotState",
    "SimClock",
    "WallClock",
    "stopwatch",
]
