"""What a robot can do: one behaviour a file, each a leaf of a task tree.

Leaves read the state and leave one motion goal a tick in the `Context` that they share; they never
command motion themselves. `LEAVES` has them by the key that a task file calls them by.
"""

from behaviours.approach import Approach
from behaviours.comparisons import AtLeast, Equals
from behaviours.conditions import ArmAt, ArmHealthy, BatteryAbove, Near, ObjectVisible
from behaviours.context import Context
from behaviours.detect import Detect, LooksLike
from behaviours.drive import Drive
from behaviours.follow import Follow
from behaviours.grasp import Grasp
from behaviours.gripper import HoldingObject, OpenGripper
from behaviours.key import Key
from behaviours.leaf import Condition, Leaf, LeafCrashedError, TwoGoalsError
from behaviours.log import Carried, TaskLog
from behaviours.look_at import LookAt
from behaviours.move_arm import MoveArm
from behaviours.navigate import Navigate
from behaviours.place import Place
from behaviours.places import slots
from behaviours.poses import BasePose, Posture, Region, ToolPose
from behaviours.progress import Progress
from behaviours.ranges import Bounds, Count, NotNegative, Percent, Positive
from behaviours.recover import Recover
from behaviours.region_empty import RegionEmpty
from behaviours.retreat_check import RetreatCheck
from behaviours.say import Say
from behaviours.scan_for_objects import ScanForObjects
from behaviours.seen import SeenObstacles
from behaviours.settings import BehaviourSettings
from behaviours.vision import Vision, VisionBeside, VisionInStep
from behaviours.wait import Wait
from perception import SeenObject, SeenObjects

LEAVES: dict[str, type[Leaf]] = {
    leaf.key: leaf
    for leaf in (
        ArmAt,
        ArmHealthy,
        AtLeast,
        BatteryAbove,
        Detect,
        Drive,
        Equals,
        Follow,
        Grasp,
        HoldingObject,
        LookAt,
        LooksLike,
        MoveArm,
        Navigate,
        Near,
        ObjectVisible,
        OpenGripper,
        Place,
        Recover,
        RegionEmpty,
        RetreatCheck,
        Say,
        ScanForObjects,
        Wait,
    )
}
"""The behaviours that come with the project, by their key in a task file."""

__all__ = [
    "LEAVES",
    "Approach",
    "BasePose",
    "BehaviourSettings",
    "Bounds",
    "Carried",
    "Condition",
    "Context",
    "Count",
    "Detect",
    "Grasp",
    "Key",
    "Leaf",
    "LeafCrashedError",
    "Navigate",
    "NotNegative",
    "OpenGripper",
    "Percent",
    "Positive",
    "Posture",
    "Progress",
    "Recover",
    "Region",
    "RetreatCheck",
    "SeenObject",
    "SeenObjects",
    "SeenObstacles",
    "TaskLog",
    "ToolPose",
    "TwoGoalsError",
    "Vision",
    "VisionBeside",
    "VisionInStep",
    "slots",
]
