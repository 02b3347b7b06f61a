"""Robots: the interface, the command gate, simulators and drivers.

`robot` defines a robot and its parts, `state` their readings, `composition` a robot made of parts.
`gate` refuses commands, with `plausibility` of readings and `motion_monitor`; `watchdog` stops the
robot when the loop stands still. `registry` chooses the driver or simulator. `sim` is the
simulator, `sim.physics` the physical one; `omron`, `panda` and `realsense` are drivers.
"""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from hw.background import InlineExecutor, one_thread
    from hw.clock import Clock, SimClock, TaskClock, TaskTime, WallClock, stopwatch
    from hw.composition import ComposedRobot
    from hw.faults import INJECTABLE, FaultInjection, InjectionError, injectable
    from hw.gate import Gate, Refusal, UntrustedRobotError
    from hw.recording import TURN, RecordedRobot, Turn
    from hw.registry import (
        DEFAULT_LEVEL,
        Backend,
        WorldError,
        WorldOptions,
        open_backend,
        simulator,
    )
    from hw.replay import Difference, ReplayRobot
    from hw.robot import (
        RECOVERY_MEMORY,
        RECOVERY_PAUSES,
        Arm,
        Base,
        Camera,
        DepthCamera,
        Gripper,
        HardwareError,
        Laser,
        LaserScanner,
        Robot,
        RobotWrapper,
    )
    from hw.state import (
        ArmState,
        BaseState,
        DepthFrame,
        DepthImage,
        Fault,
        FaultKind,
        GripperState,
        LaserReading,
        LaserScan,
        LocalisedPose,
        RobotState,
    )
    from hw.truth import MAY_TOUCH, DisturbableWorld, Touch, TrueObject, Truth
    from hw.watchdog import SIMULATION, LoopBlockedError, Patience, Watchdog
else:
    __getattr__ = lazy_face(__name__)
