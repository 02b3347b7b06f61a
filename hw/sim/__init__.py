"""The kinematic simulator: a world of objects, what a depth camera sees, what a gripper can hold.

`load_scene` builds a `World` from a scene file and a seed. `World` decides by contact geometry what
closing the fingers does; it knows nothing of time. `DepthRenderer` and `D435Noise` make depth
images of it.
"""

from hw.sim.body import Dynamics, SimBody
from hw.sim.furniture import Container, Fixture, Objects, Table
from hw.sim.grasp_contact import Reason
from hw.sim.hand import Hand
from hw.sim.kinematic import KinematicBody
from hw.sim.layout import build_world, load_fixtures, load_scene, scene_mistakes
from hw.sim.noise import D435Noise
from hw.sim.objects import HELDOUT, HOUSEHOLD, MODELLED, OBJECT_CLASSES, RANDOM_BODIES, TRAIN
from hw.sim.photograph import Grey, photograph
from hw.sim.render import DepthRenderer, painted
from hw.sim.robot import kinematic_robot
from hw.sim.scene import Scene, SceneError, find_scene, read_scene, scene_names
from hw.sim.sim_object import Motion, SimObject
from hw.sim.surface import Visible
from hw.sim.walker import Walker
from hw.sim.world import GraspOutcome, World

__all__ = [
    "HELDOUT",
    "HOUSEHOLD",
    "MODELLED",
    "OBJECT_CLASSES",
    "RANDOM_BODIES",
    "TRAIN",
    "Container",
    "D435Noise",
    "DepthRenderer",
    "Dynamics",
    "Fixture",
    "GraspOutcome",
    "Grey",
    "Hand",
    "KinematicBody",
    "Motion",
    "Objects",
    "Reason",
    "Scene",
    "SceneError",
    "SimBody",
    "SimObject",
    "Table",
    "Visible",
    "Walker",
    "World",
    "build_world",
    "find_scene",
    "kinematic_robot",
    "load_fixtures",
    "load_scene",
    "painted",
    "photograph",
    "read_scene",
    "scene_mistakes",
    "scene_names",
]
