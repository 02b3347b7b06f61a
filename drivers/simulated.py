"""Simulated parts of a real robot: the drivers `simulated`, which share one kinematic body.

Their world is the map of the robot's file; without one it is empty, or for a simulated camera the
scene of the run. A real arm or base moves in it, too: the body is where that tells to be.
"""

from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from controller import Command
from hw import DriverContext, HardwareError, Worker
from hw.sim import (
    RENDERING,
    Dynamics,
    KinematicBody,
    Localisation,
    SimPart,
    World,
    load_scene,
    made_wrong,
    part_of,
)
from robots import SIMULATED, DriverOptions


class PartlyRealBody(KinematicBody):
    """A simulated body with a real arm or a real base."""

    parts: Mapping[str, Any] = {}  # of the robot by their kinds

    def _integrate(self, command: Command, dt: float) -> None:
        arm, base = self.parts.get("arm"), self.parts.get("base")
        with suppress(HardwareError):  # not connected: told where the part itself is read
            if arm is not None and not isinstance(arm, SimPart):
                self.q, self.qd = arm.read().q, np.zeros(len(self.q))
            if base is not None and not isinstance(base, SimPart):
                self.wTb, self.base_twist = base.read().oTb, np.zeros(3)
        super()._integrate(command, dt)


def _part(options: DriverOptions, context: DriverContext, *, kind: str) -> object:
    """A simulated part; the first one makes the body. SceneError: the scene has a mistake."""
    clock, seed = context.clock, context.seed
    body = next((one.body for one in context.parts.values() if isinstance(one, SimPart)), None)
    if body is None:
        truly, process, _ = made_wrong(context.robot, Localisation(), seed)
        body = PartlyRealBody(truly, _world(context), clock, Dynamics(), process)
        body.parts = context.parts
        body.truth = body.world if _shows_scene(context) else None
    return part_of(body, kind, seed=seed, rendering=Worker(clock, RENDERING))


def _shows_scene(context: DriverContext) -> bool:
    if context.file is None or context.file.map or not context.scene:
        return False
    return context.file.hardware.camera.driver == SIMULATED


def _world(context: DriverContext) -> World:
    if _shows_scene(context):
        return load_scene(context.scene, context.seed, context.robot.base.size[:2])
    if context.file is None or not context.file.map:
        return World((), ())
    return load_scene(context.file.map, context.seed)


simulated_arm = partial(_part, kind="arm")
simulated_base = partial(_part, kind="base")
simulated_gripper = partial(_part, kind="gripper")
simulated_camera = partial(_part, kind="camera")
simulated_laser = partial(_part, kind="laser")
