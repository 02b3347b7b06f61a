"""The simulator: worlds of objects, simulated sensors, and robots, kinematic or physical."""

from hw.sim.body import Dynamics, SimBody
from hw.sim.camera import D435Noise, DepthRenderer, Grey, painted, photograph
from hw.sim.contact import separation
from hw.sim.grasp_contact import GraspOutcome, Reason
from hw.sim.kinematic import KinematicBody
from hw.sim.laser import SimLaser
from hw.sim.levels import LEVELS, Localisation, load_localisation
from hw.sim.localisation import LocalisationProcess, made_wrong
from hw.sim.objects import HELDOUT, HOUSEHOLD, MODELLED, OBJECT_CLASSES, RANDOM_BODIES, TRAIN
from hw.sim.robot import kinematic_robot
from hw.sim.robot_shapes import Hand
from hw.sim.scene import (
    Scene,
    build_world,
    find_scene,
    load_fixtures,
    load_scene,
    read_scene,
    scene_mistakes,
    scene_names,
)
from hw.sim.scene_schema import Container, Fixture, Objects, SceneError, Table
from hw.sim.sim_object import Motion, SimObject, Visible
from hw.sim.walker import Walker
from hw.sim.world import World
