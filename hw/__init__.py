"""Robots: the interface, the command gate, replay, simulators and drivers."""

from hw.checked_values import RefusedError, covariance, number, numbers
from hw.clock import Clock, SimClock, TaskClock, TaskTime, WallClock, epoch, stopwatch
from hw.composition import ComposedRobot, InlineExecutor
from hw.findings import Finding, Verdict, ages, is_good, watched
from hw.gate import Gate, Refusal, UntrustedRobotError
from hw.loop_watchdog import SIMULATION, LoopBlockedError, Patience, Watchdog
from hw.plausible_readings import OLDEST
from hw.real_parts import DriverContext, parts_of
from hw.recording import RecordedRobot, Turn, turn_type
from hw.replay_robot import Difference, ReplayRobot
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
    Array,
    BaseState,
    DepthArray,
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
from hw.threads import Worker, begun
from hw.truth import MAY_TOUCH, DisturbableWorld, Touch, TrueObject, Truth
from hw.worlds import (
    DEFAULT_LEVEL,
    Backend,
    Injector,
    WorldError,
    WorldOptions,
    find_world,
    open_backend,
    world_names,
)
