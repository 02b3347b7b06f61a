"""Robots: the interface, the command gate, faults, replay, simulators and drivers."""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from hw.clock import Clock, SimClock, TaskClock, TaskTime, WallClock, Worker, epoch, stopwatch
    from hw.composition import ComposedRobot, InlineExecutor
    from hw.contract import BrokenContractError, check_driver
    from hw.drivers import DriverContext, parts_of
    from hw.faults import INJECTABLE, FaultInjection, InjectionError, injectable
    from hw.gate import Gate, Refusal, UntrustedRobotError
    from hw.recording import RecordedRobot, Turn, turn_type
    from hw.registry import (
        DEFAULT_LEVEL,
        WORLDS,
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
        PassivePart,
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
    from hw.threads import begun
    from hw.truth import MAY_TOUCH, DisturbableWorld, Touch, TrueObject, Truth
    from hw.watchdog import SIMULATION, LoopBlockedError, Patience, Watchdog
else:
    __getattr__ = lazy_face(__name__)
