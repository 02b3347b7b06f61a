"""Simulated worlds: a robot of one body among the objects of a scene."""

from collections.abc import Callable
from dataclasses import dataclass

from hw.clock import Clock, SimClock, WallClock
from hw.sim.body import SimBody
from hw.sim.kinematic import KinematicBody
from hw.sim.levels import load_localisation
from hw.sim.scene import load_scene
from hw.sim.sim_robot import simulated_robot
from hw.threads import Worker
from hw.worlds import DEFAULT_LEVEL, Backend, WorldOptions
from robots import RobotDescription, load_robot, with_base_speeds

RENDERING = 0.02  # from the capture of an image to its arrival [s]


def _anything(robot: RobotDescription) -> None:
    """Refuse no robot."""


@dataclass(frozen=True)
class SimulatedWorld:
    """A world of rigid objects; `check` raises UserError for a robot that cannot be in it."""

    name: str
    body: Callable[[], type[SimBody]]
    """What moves the robot, imported when it is asked for; may raise UserError."""
    check: Callable[[RobotDescription], None] = _anything

    def __call__(self, robot: str, options: WorldOptions) -> Backend:
        """A robot in the scene of the options."""
        body, described = self.body(), load_robot(robot)
        described = with_base_speeds(described, options.base_speed, options.reverse_speed)
        self.check(described)
        level = load_localisation(options.localisation or DEFAULT_LEVEL)
        truth = load_scene(options.scene, options.seed, described.base.size[:2], level.moved)
        clock: Clock = WallClock() if options.real_clock else SimClock(paced=options.paced)
        made = simulated_robot(
            body,
            described,
            truth,
            clock,
            seed=options.seed,
            localisation=level,
            rendering=Worker(clock, RENDERING),
        )
        return Backend(robot=made, clock=clock, truth=truth, world=self.name, of_scene=True)


kinematic_world = SimulatedWorld("kinematic", lambda: KinematicBody)
