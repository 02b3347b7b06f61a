"""The behaviours that come with the project."""

from __future__ import annotations

from behaviours.comparisons import AtLeast, Equals
from behaviours.conditions import AllPlaced, ArmAt, ArmHealthy, BatteryAbove, Near, ObjectVisible
from behaviours.detect import Detect, LooksLike
from behaviours.drive import Drive
from behaviours.follow import Follow
from behaviours.grasp import Grasp
from behaviours.gripper import HoldingObject, OpenGripper
from behaviours.leaf import Leaf
from behaviours.look_at import LookAt
from behaviours.move_arm import MoveArm
from behaviours.navigate import Navigate
from behaviours.place import Place
from behaviours.recover import Recover
from behaviours.region_empty import RegionEmpty
from behaviours.retreat_check import RetreatCheck
from behaviours.say import Say
from behaviours.scan_for_objects import ScanForObjects
from behaviours.wait import Wait

LEAVES: dict[str, type[Leaf]] = {
    leaf.key: leaf
    for leaf in (
        AllPlaced,
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
