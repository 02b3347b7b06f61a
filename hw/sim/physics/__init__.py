"""The physical simulator in MuJoCo, an extra that only this room imports."""

from functools import partial

from hw.sim.physics.body import PhysicalBody
from hw.sim.physics.floating_hand import FloatingHand
from hw.sim.robot import simulated_robot

physical_robot = partial(simulated_robot, PhysicalBody)  # its world is moved by contacts
