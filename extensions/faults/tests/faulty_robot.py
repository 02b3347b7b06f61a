"""The simulated robot over a table with a block, and faults to give it."""

import numpy as np
from harness import Harness, block, table_world

from controller import Command
from extensions.faults.injection import FaultInjection

DT = 0.01


class Faulty:
    def __init__(self, seed: int = 0, world=None) -> None:
        self.harness = Harness(world or table_world(block()))
        self.inner = self.harness.robot
        self.robot = FaultInjection(self.inner, self.harness.world, seed)
        self.now = 0.0

    def read(self, seconds: float = 0.0, command: Command | None = None):
        """The reading after a while of a command."""
        for _ in range(round(seconds / DT)):
            if command is not None:
                self.robot.send(command)
            self.now += DT
            self.harness.clock.sleep_until(self.now)
            state = self.robot.read()
        return state if seconds else self.robot.read()

    def true(self):
        return self.inner.read()


def turning(speed: float) -> Command:
    return Command(base_twist=np.zeros(3), qd=np.full(7, speed))
