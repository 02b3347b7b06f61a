"""What a robot can do: one behaviour a file, each a leaf of a task tree.

Leaves read the state and leave one motion goal a tick in the `Context` that they share; they never
command motion themselves. `LEAVES` has them by the key that a task file calls them by.
"""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from behaviours.aiming import straight_down
    from behaviours.approach import Approach
    from behaviours.context import Context
    from behaviours.detect import Detect
    from behaviours.errors import LeafCrashedError, TwoGoalsError
    from behaviours.grasp import Grasp
    from behaviours.gripper import OpenGripper
    from behaviours.key import Key
    from behaviours.leaf import Condition, Leaf
    from behaviours.leaves import LEAVES
    from behaviours.log import Carried, TaskLog
    from behaviours.navigate import Navigate
    from behaviours.place import Place
    from behaviours.places import slots
    from behaviours.poses import BasePose, Posture, Region, ToolPose
    from behaviours.progress import Progress
    from behaviours.ranges import Bounds, Count, NotNegative, Percent, Positive
    from behaviours.recover import Recover
    from behaviours.retreat_check import RetreatCheck
    from behaviours.seen import SeenObstacles
    from behaviours.settings import BehaviourSettings
    from behaviours.vision import Vision, VisionBeside, VisionInStep
    from perception import DetectedObject, DetectedObjects
else:
    __getattr__ = lazy_face(__name__)

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
    "DetectedObject",
    "DetectedObjects",
    "Grasp",
    "Key",
    "Leaf",
    "LeafCrashedError",
    "Navigate",
    "NotNegative",
    "OpenGripper",
    "Percent",
    "Place",
    "Positive",
    "Posture",
    "Progress",
    "Recover",
    "Region",
    "RetreatCheck",
    "SeenObstacles",
    "TaskLog",
    "ToolPose",
    "TwoGoalsError",
    "Vision",
    "VisionBeside",
    "VisionInStep",
    "slots",
    "straight_down",
]
