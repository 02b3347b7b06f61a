"""The physical simulator: the same robots, scenes and images as the kinematic one, in MuJoCo.

Only this room imports MuJoCo, which is an extra.
"""

from functools import partial

from hw.sim.physics.body import PhysicalBody
from hw.sim.physics.floating_hand import FloatingHand
from hw.sim.robot import simulated_robot

physical_robot = partial(simulated_robot, PhysicalBody)
"""A robot of rigid bodies: the world around it is moved by contacts alone."""
