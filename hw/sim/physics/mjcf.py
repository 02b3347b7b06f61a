"""MuJoCo's models of a robot in a world, or of its hand alone, from description and shapes.

Nothing is drawn here: images are rendered from the same shapes as in the kinematic world. So the
model has only what moves and what can be touched.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco

from hw.sim.physics.floating import add_floating_hand
from hw.sim.physics.robot import add_robot
from hw.sim.physics.shapes import ALL, Kind, add_body, add_geom
from hw.sim.sim_object import SimObject
from hw.sim.world import World
from robots import Box, Plane, RobotDescription, volume

TIMESTEP = 0.002  # [s]

_IMPRATIO = 10.0  # How much stiffer friction is than pressure: what is held creeps less
_FRICTION = 0.5  # Of furniture and walkers
_MEMORY = 64 * 2**20  # For contacts and what they need, most of it never touched [bytes]


def robot_model_in(description: RobotDescription, world: World) -> mujoco.MjModel:
    """The model of a robot in a world, its bodies where they are when a run begins.

    Bodies besides those of `add_robot` are called `walker/N` and `object/N`, geoms of the
    furniture `fixture/N`.
    """
    return _model(world, lambda spec: add_robot(spec, description))


def hand_model_in(description: RobotDescription, world: World) -> mujoco.MjModel:
    """The same world around only the hand of a robot; see `add_floating_hand`."""
    return _model(world, lambda spec: add_floating_hand(spec, description))


def _model(world: World, add: Callable[[Any], None]) -> mujoco.MjModel:
    """A world, and in it what is added to its specification."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    option = spec.option
    option.timestep = TIMESTEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = _IMPRATIO
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    spec.memory = _MEMORY
    for number, fixture in enumerate(world.fixtures):
        kind = Kind.FLOOR if isinstance(fixture.shape, Plane) else Kind.FIXTURE
        add_geom(spec, spec.worldbody, fixture, f"fixture/{number}", kind, 0, _FRICTION)
    for number, walker in enumerate(world.walkers):
        body = add_body(spec.worldbody, f"walker/{number}", walker.pose)
        body.mocap = True
        for part, geom in enumerate(walker.parts):
            name = f"walker/{number}/{part}"
            add_geom(spec, body, geom, name, Kind.WALKER, 0, _FRICTION)
    add(spec)
    for number, obj in enumerate(world.objects):
        _object(spec, f"object/{number}", obj)
    return spec.compile()


def _object(spec: Any, name: str, obj: SimObject) -> None:
    body = add_body(spec.worldbody, name, obj.pose)
    body.add_freejoint(name=name)
    total = sum(volume(part.shape) for part in obj.parts)
    for number, part in enumerate(obj.parts):
        geom = add_geom(spec, body, part, f"{name}/{number}", Kind.OBJECT, ALL, obj.friction)
        geom.mass = obj.mass * volume(part.shape) / total
        if not isinstance(part.shape, Box):
            geom.condim = 6  # it may roll
