"""The simulated world: what there is, what a depth camera sees of it, what the fingers can hold.

`load_scene` makes a `World` from a scene file and a seed; `DepthRenderer` and `D435Noise` look
at it; `World` decides by contact geometry what closing the fingers does. It knows nothing of time.
"""

from hw.sim.grasp_contact import Reason
from hw.sim.hand import hand_shapes
from hw.sim.layout import load_scene
from hw.sim.noise import D435Noise
from hw.sim.render import DepthRenderer
from hw.sim.robot import kinematic_robot
from hw.sim.scene import SceneError, scene_names
from hw.sim.sim_object import SimObject
from hw.sim.world import GraspOutcome, World
from robots.shapes import Box, Capsule, Cylinder, Geom, Plane, Sphere

__all__ = [
    "Box",
    "Capsule",
    "Cylinder",
    "D435Noise",
    "DepthRenderer",
    "Geom",
    "GraspOutcome",
    "Plane",
    "Reason",
    "SceneError",
    "SimObject",
    "Sphere",
    "World",
    "hand_shapes",
    "kinematic_robot",
    "load_scene",
    "scene_names",
]
