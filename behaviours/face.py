"""The names of `behaviours` that need numpy: imported at the first use of one."""

from behaviours.core.around import Around
from behaviours.core.context import Context, Intent, Now
from behaviours.core.directions import ApproachWord
from behaviours.core.leaf import Condition, Leaf
from behaviours.core.log import Carried, TaskLog
from behaviours.core.motion import Approach, Progress
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
from behaviours.sensing.depth_obstacles import DepthObstacles
from behaviours.sensing.localiser import Localiser
from behaviours.sensing.map_matching import MapSensors
from behaviours.sensing.moved_furniture import map_surfaces
from behaviours.sensing.vision import Vision
from behaviours.views.grasp_target import DOUBTFUL, LOOK_HEIGHT, LOOKS
from behaviours.views.viewpoint import straight_down
