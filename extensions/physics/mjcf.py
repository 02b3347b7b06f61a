"""MuJoCo models of a robot in a world, or of its hand alone: collision shapes only."""

from collections.abc import Callable
from math import sqrt
from typing import Any

import mujoco
import numpy as np
from pinocchio import SE3, Inertia

from extensions.physics.mujoco_robot import add_hand, add_robot
from extensions.physics.mujoco_shapes import ALL, Kind, add_body, add_geom, weigh
from hw.sim import SimObject, World
from robots import Box, Plane, RobotDescription, volume

TIMESTEP = 0.002  # [s]

_IMPRATIO = 10.0  # stiffness of friction relative to pressure
_NOSLIP = 3  # more iterations against slip: soft friction lets what is held creep by 1 mm/s
_FRICTION = 0.5  # Of furniture and walkers
_MEMORY = 64 * 2**20  # for contacts, most of it never touched [bytes]
CARRIER = ("x", "y", "z", "yaw")  # joints and motors along and about the axes of the approach
DOWN = SE3(np.diag([1.0, -1.0, -1.0]), np.zeros(3))  # end effector on its carrier: it points down

_MASS, _TURNING = 4.0, 0.05  # of the missing arm, as felt at the tool [kg, kg m²]
_STIFFNESS, _TURNING_STIFFNESS = 16000.0, 200.0  # as of the arm at 0.5 m [N/m, Nm/rad]
_FORCE, _TORQUE = 150.0, 12.0  # limits of the servos [N, Nm]


def robot_model_in(description: RobotDescription, world: World) -> mujoco.MjModel:
    """The model of a robot in a world as a run begins: `walker/N`, `object/N` and `fixture/N`."""
    return _model(world, lambda spec: add_robot(spec, description))


def hand_model_in(description: RobotDescription, world: World, wTa: SE3) -> mujoco.MjModel:
    """The same world around the hand of a robot alone, which approaches along -z of a."""
    return _model(world, lambda spec: _add_floating_hand(spec, description, wTa))


def _model(world: World, add: Callable[[Any], None]) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    option = spec.option
    option.timestep = TIMESTEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = _IMPRATIO
    option.noslip_iterations = _NOSLIP
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


def _add_floating_hand(spec: Any, description: RobotDescription, wTa: SE3) -> None:
    """Add the hand of a robot, along -z of a, its end effector at the origin; joints: `CARRIER`."""
    carrier = add_body(spec.worldbody, "carrier", wTa)
    carrier.gravcomp = 1.0
    weigh(carrier, Inertia.FromSphere(0.1, 0.05))
    for name, axis in zip(CARRIER, (*np.eye(3), np.eye(3)[2]), strict=True):
        turns = name == "yaw"
        mass = _TURNING if turns else _MASS
        stiffness = _TURNING_STIFFNESS if turns else _STIFFNESS
        force = _TORQUE if turns else _FORCE
        kind = mujoco.mjtJoint.mjJNT_HINGE if turns else mujoco.mjtJoint.mjJNT_SLIDE
        carrier.add_joint(name=name, type=kind, axis=axis, armature=mass)
        servo = spec.add_actuator(
            name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, forcerange=(-force, force)
        )
        servo.set_to_position(kp=stiffness, kv=2.0 * sqrt(stiffness * mass))
    add_hand(spec, carrier, DOWN * description.gripper.hTe.inverse(), description)
