"""The simulator: worlds of objects, simulated sensors, and robots, kinematic or physical."""

from hw.sim.body import Dynamics, Reflex, SimBody
from hw.sim.camera import D435Noise, DepthRenderer, painted
from hw.sim.contact import separation
from hw.sim.grasp_contact import GraspOutcome, Reason
from hw.sim.kinematic import KinematicBody
from hw.sim.levels import LEVELS, Localisation, load_localisation
from hw.sim.localisation_errors import LocalisationProcess, made_wrong
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
from hw.sim.sim_laser import SimLaser
from hw.sim.sim_object import Motion, SimObject, Visible
from hw.sim.sim_robot import SimPart, kinematic_robot, part_of, simulated_robot
from hw.sim.sim_robot_shapes import BASE, CAMERA, FINGERS, HAND, HELD, Hand, Member, members
from hw.sim.sim_world import World
from hw.sim.simulated_world import RENDERING, SimulatedWorld, kinematic_world
from hw.sim.walker import Walker
