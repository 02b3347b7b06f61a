"""The leaves that come with the project, by their keys in a task file."""

import behaviours.conditions as conditions
import behaviours.seen as seen
from behaviours.core.leaf import Leaf
from behaviours.detect import Detect
from behaviours.drive import Drive
from behaviours.follow import Follow
from behaviours.grasp import Grasp
from behaviours.hand_over import HandOver, Receive
from behaviours.look_at import LookAt
from behaviours.move_arm import MoveArm
from behaviours.navigate import Navigate
from behaviours.open_gripper import OpenGripper
from behaviours.place import Place
from behaviours.recover import Recover
from behaviours.region_empty import RegionEmpty
from behaviours.retreat_check import RetreatCheck
from behaviours.say import Say
from behaviours.scan_for_objects import ScanForObjects
from behaviours.snapshot import Snapshot
from behaviours.wait import Wait

LEAVES: dict[str, type[Leaf]] = {
    leaf.key: leaf
    for leaf in (
        conditions.AllPlaced,
        conditions.ArmHealthy,
        conditions.BatteryAbove,
        conditions.Compare,
        Detect,
        Drive,
        Follow,
        Grasp,
        HandOver,
        conditions.HoldingObject,
        conditions.Localised,
        LookAt,
        MoveArm,
        Navigate,
        conditions.Near,
        seen.ObjectVisible,
        seen.ObstacleWithin,
        OpenGripper,
        Place,
        Receive,
        Recover,
        RegionEmpty,
        RetreatCheck,
        Say,
        ScanForObjects,
        Snapshot,
        Wait,
    )
}
