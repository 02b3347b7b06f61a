"""What `frankie_task` has, imported when it is first asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from py_trees.common import Status

from app.live import LiveRun, Observer, Snapshot
from behaviours import (
    Approach,
    BasePose,
    Bounds,
    Condition,
    Context,
    Count,
    Key,
    Leaf,
    NotNegative,
    Percent,
    Positive,
    Posture,
    Progress,
    Region,
    ToolPose,
    Vision,
)
from config import UserError
from controller import BaseGoal, Command, MotionGoal, PoseGoal, PostureGoal, StepReport
from hw import (
    Arm,
    ArmState,
    Backend,
    Base,
    BaseState,
    Clock,
    ComposedRobot,
    DepthCamera,
    DepthFrame,
    DepthImage,
    DriverContext,
    Fault,
    FaultKind,
    Gripper,
    GripperState,
    HardwareError,
    LaserReading,
    LaserScanner,
    PassivePart,
    Robot,
    RobotState,
    SimClock,
    TaskTime,
    WorldOptions,
)
from perception import DetectedObjects, Labelled, Recogniser
from robots import DriverOptions, RobotDescription, load_robot

if TYPE_CHECKING:
    from app.core import Result

__all__ = [
    "Approach",
    "Arm",
    "ArmState",
    "Backend",
    "Base",
    "BaseGoal",
    "BasePose",
    "BaseState",
    "Bounds",
    "Clock",
    "Command",
    "ComposedRobot",
    "Condition",
    "Context",
    "Count",
    "DepthCamera",
    "DepthFrame",
    "DepthImage",
    "DetectedObjects",
    "DriverContext",
    "DriverOptions",
    "Fault",
    "FaultKind",
    "Gripper",
    "GripperState",
    "HardwareError",
    "Key",
    "Labelled",
    "LaserReading",
    "LaserScanner",
    "Leaf",
    "LiveRun",
    "MotionGoal",
    "NotNegative",
    "Observer",
    "PassivePart",
    "Percent",
    "PoseGoal",
    "Positive",
    "Posture",
    "PostureGoal",
    "Progress",
    "Recogniser",
    "Region",
    "Robot",
    "RobotDescription",
    "RobotState",
    "SimClock",
    "Snapshot",
    "Status",
    "StepReport",
    "TaskTime",
    "ToolPose",
    "UserError",
    "Vision",
    "WorldOptions",
    "load_robot",
    "run_task",
]


def run_task(
    tree: str | Path,
    *,
    robot: str = "frankie",
    world: str = "kinematic",
    scene: str | None = None,
    seed: int = 0,
    parameters: Mapping[str, str] | None = None,
    record: str | Path = "runs",
    armed: bool = False,
    map: str | Path | None = None,
    places: str | Path | None = None,
) -> Result:
    """Run a task as `frankie-task run` does, without a viewer.

    Args:
        tree: a task file, or the name of a shipped task.
        robot: the body: `frankie`, `omni`, or a robot file.
        world: what moves it.
        scene: a shipped scene or a scene file; None takes the one that the task names.
        seed: of the objects and of the camera's noise.
        parameters: values of task parameters, as texts.
        record: where the folder of the run is made.
        armed: whether a robot with drivers may move.
        map: a scene file with the furniture; None takes that of the world or of the robot file.
        places: a file of poses and regions, used instead of the task's own.

    Returns:
        The outcome, the summary and the folder of the run.

    Raises:
        UserError: bad input; nothing has moved.
        HardwareError: the robot cannot be connected.
    """
    from app.core import RunOptions
    from app.core import run_task as run
    from trees import find

    return run(
        RunOptions(
            tree=find(str(tree)),
            robot=robot,
            world=world,
            scene=scene,
            seed=seed,
            parameters=parameters or {},
            record=Path(record),
            armed=armed,
            map=Path(map) if map else None,
            places=Path(places) if places else None,
        )
    )
