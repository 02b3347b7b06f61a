"""The physical simulator: the same robots, scenes and images as the kinematic one, on MuJoCo.

Only this room imports MuJoCo, which is an extra.
"""

from collections.abc import Callable
from concurrent.futures import Executor

from hw.background import InlineExecutor
from hw.clock import Clock
from hw.composition import ComposedRobot
from hw.sim.body import Dynamics
from hw.sim.noise import D435Noise
from hw.sim.physics.body import PhysicalBody
from hw.sim.robot import simulated_robot
from hw.sim.world import World
from robots import RobotDescription

__all__ = ["PhysicalBody", "physical_robot"]


def physical_robot(
    description: RobotDescription,
    world: World,
    clock: Clock,
    *,
    seed: int = 0,
    dynamics: Dynamics | None = None,
    noise: D435Noise | None = None,
    background: Callable[[], Executor] = InlineExecutor,
) -> ComposedRobot:
    """A robot of rigid bodies: the world around it is moved by contacts alone.

    Args:
        description: which robot.
        world: what is around it; poses and what is held are kept up to date in it.
        clock: simulated time.
        seed: of the camera's noise.
        dynamics: how it answers; None for the usual way.
        noise: of the camera; None for that of a D435.
        background: where images are rendered and what takes time is done; inline, a run is
            the same every time.
    """
    body = PhysicalBody(description, world, clock, dynamics or Dynamics())
    return simulated_robot(body, clock, seed=seed, noise=noise, background=background)
