"""The robot: one interface, and the robots behind it.

`robot` says what a robot and its parts are, `composition` makes one out of parts, `clock` says
where time comes from, `gate` what may reach the robot, `watchdog` what stops it when the loop
stands still, `registry` which robots and worlds there
are. `sim` is the kinematic simulator; drivers of real hardware stand beside it. A task never knows
which it got.
"""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from hw.background import InlineExecutor, one_thread
    from hw.clock import Clock, SimClock, TaskClock, TaskTime, WallClock, stopwatch
    from hw.composition import ComposedRobot
    from hw.faults import INJECTABLE, FaultInjection, Injectable, InjectionError, injectable
    from hw.frame import DepthFrame, DepthImage
    from hw.gate import Gate, Refusal, UntrustedRobotError
    from hw.recording import TURN, Notes, RecordedRobot, Turn
    from hw.registry import (
        Backend,
        WorldError,
        WorldOptions,
        open_backend,
        simulator,
        world_names,
    )
    from hw.replay import Difference, RecordEndsError, ReplayRobot
    from hw.robot import Arm, Base, Camera, DepthCamera, Gripper, HardwareError, Robot
    from hw.state import ArmState, BaseState, Fault, FaultKind, GripperState, RobotState
    from hw.truth import MAY_TOUCH, DisturbableWorld, Touch, TrueObject, Truth
    from hw.watchdog import SIMULATION, LoopBlockedError, Patience, Watchdog
    from hw.wrapper import RobotWrapper
else:
    __getattr__ = lazy_face(__name__)

__all__ = [
    "INJECTABLE",
    "MAY_TOUCH",
    "SIMULATION",
    "TURN",
    "Arm",
    "ArmState",
    "Backend",
    "Base",
    "BaseState",
    "Camera",
    "Clock",
    "ComposedRobot",
    "DepthCamera",
    "DepthFrame",
    "DepthImage",
    "Difference",
    "DisturbableWorld",
    "Fault",
    "FaultInjection",
    "FaultKind",
    "Gate",
    "Gripper",
    "GripperState",
    "HardwareError",
    "Injectable",
    "InjectionError",
    "InlineExecutor",
    "LoopBlockedError",
    "Notes",
    "Patience",
    "RecordEndsError",
    "RecordedRobot",
    "Refusal",
    "ReplayRobot",
    "Robot",
    "RobotState",
    "RobotWrapper",
    "SimClock",
    "TaskClock",
    "TaskTime",
    "Touch",
    "TrueObject",
    "Truth",
    "Turn",
    "UntrustedRobotError",
    "WallClock",
    "Watchdog",
    "WorldError",
    "WorldOptions",
    "injectable",
    "one_thread",
    "open_backend",
    "simulator",
    "stopwatch",
    "world_names",
]
