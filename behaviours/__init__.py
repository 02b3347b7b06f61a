"""What a robot can do: one behaviour a file, each a leaf of a task tree.

Leaves read the state and leave one motion goal a tick in the `Context` that they share; they never
command motion themselves. `LEAVES` has them by the key that a task file calls them by.
"""

from behaviours.context import Context
from behaviours.eyes import Eyes
from behaviours.fingers import HoldingObject, OpenGripper
from behaviours.grasp import Grasp
from behaviours.leaf import Leaf, LeafCrashedError
from behaviours.log import Carried, TaskLog
from behaviours.names import BasePose, Posture, Region, ToolPose
from behaviours.navigate import Navigate
from behaviours.place import Place
from behaviours.recover import Recover
from behaviours.region_empty import RegionEmpty
from behaviours.retreat_check import RetreatCheck
from behaviours.small import ArmHealthy, Wait

LEAVES: dict[str, type[Leaf]] = {
    leaf.key: leaf
    for leaf in (
        ArmHealthy,
        Grasp,
        HoldingObject,
        Navigate,
        OpenGripper,
        Place,
        Recover,
        RegionEmpty,
        RetreatCheck,
        Wait,
    )
}
"""The behaviours that come with the project, by their key in a task file."""

__all__ = [
    "LEAVES",
    "BasePose",
    "Carried",
    "Context",
    "Eyes",
    "Leaf",
    "LeafCrashedError",
    "Posture",
    "Region",
    "TaskLog",
    "ToolPose",
]
