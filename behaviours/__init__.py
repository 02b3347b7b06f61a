"""Behaviours: the leaves of task trees, each in the file of its key, conditions in `conditions`.

Leaves read the state and set one motion goal a tick in the `Context` that they share; they never
command motion themselves. `LEAVES` has them by key.
"""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from behaviours.core.context import Context
    from behaviours.core.directions import ApproachWord
    from behaviours.core.errors import LeafCrashedError
    from behaviours.core.leaf import Condition, Leaf
    from behaviours.core.log import Carried, TaskLog
    from behaviours.core.motion import Approach, Progress
    from behaviours.core.parameter_types import (
        BasePose,
        Bounds,
        Count,
        Key,
        MapPlace,
        NotNegative,
        Percent,
        Positive,
        Posture,
        Region,
        ToolPose,
    )
    from behaviours.core.reachable_directions import region_direction, tilted_if_needed
    from behaviours.detect import Detect
    from behaviours.exact_place import region_at
    from behaviours.grasp import Grasp
    from behaviours.leaves import LEAVES
    from behaviours.navigate import Navigate
    from behaviours.open_gripper import OpenGripper
    from behaviours.place import Place
    from behaviours.places import slots
    from behaviours.recover import Recover
    from behaviours.retreat_check import RetreatCheck
    from behaviours.sensing.depth_obstacles import DepthObstacles
    from behaviours.sensing.furniture import map_surfaces
    from behaviours.sensing.localisation import SENSORS, Localiser
    from behaviours.sensing.vision import Vision
    from behaviours.views.grasp_target import DOUBTFUL, LOOK_HEIGHT, LOOKS
    from behaviours.views.viewpoint import straight_down
    from perception import DetectedObject, DetectedObjects
else:
    __getattr__ = lazy_face(__name__)
