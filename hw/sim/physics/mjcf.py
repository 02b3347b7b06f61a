"""MuJoCo's model of a robot in a world, out of the robot's description and the world's shapes.

Nothing is drawn here: images are rendered from the same shapes as in the kinematic world. So the
model has only what moves and what can be touched.
"""

from __future__ import annotations

from enum import IntFlag
from typing import Any

import mujoco
import numpy as np
from pinocchio import SE3, Inertia, Quaternion

from hw.sim.members import FINGERS, members
from hw.sim.sim_object import SimObject
from hw.sim.world import World
from robots import (
    Array,
    Box,
    Capsule,
    Cylinder,
    Geom,
    Hull,
    Plane,
    RobotDescription,
    Shape,
    Sphere,
    volume,
)

TIMESTEP = 0.002
"""[s]."""

SIDES = ("left", "right")
AXES = ("x", "y", "yaw")
"""Joints of the base."""
ARM = tuple(f"joint{number}" for number in range(1, 8))

_PADS = (-88000.0, -600.0)
"""Stiffness [1/s²] and damping [1/s] of the pads, negative, as MuJoCo wants them; with any partner.
Friction knows no place, only a velocity that it takes away at this damping: what is carried round
at ω creeps by about ω²r / 600 s. A step lets it grow to 1000; there it would shake."""
_SHELL = (0.014, 1.0)
"""Time constant [s] and damping ratio of all other shapes of the robot, whose covers yield: with a
partner the mean of both counts."""
_HARD = (0.006, 1.0)
"""The same of furniture, objects and walkers."""
_SOLIMP = (0.95, 0.99, 0.0005, 0.5, 2.0)
"""Contacts are nearly rigid from the first half millimetre on."""
_IMPRATIO = 10.0
"""How much stiffer friction is than pressure: what is held creeps less."""

_ROBOT_FRICTION, _FURNITURE_FRICTION = 0.3, 0.5
"""Of two surfaces the rougher counts; an object brings its own."""
_TORSION, _ROLLING = 0.005, 0.0005
"""Radii over which contacts resist to twisting and rolling [m]."""

_STIFFNESS = np.array([4000.0] * 4 + [1500.0] * 3)
"""Of the servos of the joints [Nm/rad]."""
_ARMATURE, _DAMPING = 0.1, 0.5
"""Of each joint's motor and gear: inertia [kg m²] and viscous friction [Nm s]."""

_DRIVE = ((20000.0, 500.0), (20000.0, 800.0), (3000.0, 250.0))
"""Of the base along x and y and about z: gain [N s/m, Nm s] and largest force [N, Nm]; along y a
differential drive has only its tyres, which hold against that much."""

_FINGER_STIFFNESS, _FINGER_DAMPING = 8000.0, 80.0
"""Of the gripper's servo [N/m, N s/m]."""
_FINGER_ARMATURE = 0.1
"""[kg]."""


_MEMORY = 64 * 2**20
"""For contacts and what they need, most of it never touched [bytes]."""


class _Kind(IntFlag):
    """What can be hit: MuJoCo's contact types."""

    FIXTURE = 1
    FLOOR = 2
    WALKER = 4
    OBJECT = 8


_ALL = sum(_Kind)


def robot_model_in(description: RobotDescription, world: World) -> mujoco.MjModel:
    """The model of a robot in a world, its bodies where they are when a run begins.

    Bodies are called `base`, `hand`, `left`, `right`, `walker/N` and `object/N`; joints as in
    `AXES`, `ARM` and `SIDES`; actuators like the joints, that of both fingers `fingers`. Geoms of
    the robot begin with their part (`link3/...`), those of the furniture are `fixture/N`.
    """
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
        kind = _Kind.FLOOR if isinstance(fixture.shape, Plane) else _Kind.FIXTURE
        _add(spec, spec.worldbody, fixture, f"fixture/{number}", kind, 0, _FURNITURE_FRICTION)
    for number, walker in enumerate(world.walkers):
        body = _body(spec.worldbody, f"walker/{number}", walker.pose)
        body.mocap = True
        for part, geom in enumerate(walker.parts):
            name = f"walker/{number}/{part}"
            _add(spec, body, geom, name, _Kind.WALKER, 0, _FURNITURE_FRICTION)
    _robot(spec, description)
    for number, obj in enumerate(world.objects):
        _object(spec, f"object/{number}", obj)
    return spec.compile()


def _robot(spec: Any, description: RobotDescription) -> None:
    base, arm, gripper = description.base, description.arm, description.gripper
    on_base = _body(spec.worldbody, "base", SE3.Identity())
    for name, axis in zip(AXES, np.eye(3)[[0, 1, 2]], strict=True):
        kind = mujoco.mjtJoint.mjJNT_HINGE if name == "yaw" else mujoco.mjtJoint.mjJNT_SLIDE
        on_base.add_joint(name=name, type=kind, axis=axis)
    on_base.add_site(name="base")
    box = Inertia.FromBox(base.mass, *base.size)
    raised = SE3(np.eye(3), np.array([0.0, 0.0, base.size[2] / 2.0]))
    _weigh(on_base, raised.act(box) + description.bTa.act(arm.inertias[0]))
    # The frames of the members: base, foot, seven links, flange of the hand, end effector.
    frames = [(on_base, SE3.Identity()), (on_base, description.bTa)]
    for name, place, inertia, (low, high) in zip(
        ARM, arm.joints, arm.inertias[1:], _ranges(description), strict=True
    ):
        parent, below = frames[-1]
        link = _body(parent, name, below * place)
        link.gravcomp = 1.0
        link.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=(0.0, 0.0, 1.0),
            range=(low, high),
            armature=_ARMATURE,
            damping=_DAMPING,
        )
        _weigh(link, inertia)
        frames.append((link, SE3.Identity()))
    hand = _body(frames[-1][0], "hand", arm.lTh)
    hand.gravcomp = 1.0
    hand.add_site(name="tool", pos=gripper.hTe.translation, quat=_quaternion(gripper.hTe))
    camera = description.camera
    housing = Inertia.FromBox(camera.mass, *(2.0 * h for h in _half(camera.body)))
    hTc = gripper.hTe * camera.eTc * camera.body.pose
    _weigh(hand, gripper.inertia + hTc.act(housing))
    frames += [(hand, SE3.Identity()), (hand, gripper.hTe)]
    fingers = {side: _finger(hand, side, description) for side in SIDES}
    for number, member in enumerate(members(description)):
        body, place = frames[member.frame]
        if member.part == FINGERS:
            body, place = fingers[member.geom.name.split()[0]], SE3.Identity()
        against = _ALL & ~_Kind.FLOOR if member.frame == 0 else _ALL  # the base stands there
        name, shape = f"{member.part}/{number}", member.geom.moved(place)
        geom = _add(spec, body, shape, name, 0, against, _ROBOT_FRICTION)
        geom.solref = _PADS if shape.name.endswith(gripper.pad.name) else _SHELL
    _actuators(spec, description)


def _finger(hand: Any, side: str, description: RobotDescription) -> Any:
    """A finger, in the end effector's axes; its joint is half of the width between the pads."""
    gripper = description.gripper
    body = _body(hand, side, gripper.hTe)
    body.gravcomp = 1.0
    half = gripper.opening / 2.0
    body.add_joint(
        name=side,
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=(0.0, 1.0 if side == "left" else -1.0, 0.0),
        range=(0.0, half),
        ref=half,  # its shapes are described with the hand open
        armature=_FINGER_ARMATURE,
    )
    lengths = (2.0 * h for h in _half(gripper.finger))
    _weigh(body, Inertia.FromBox(gripper.finger_mass, *lengths))
    return body


def _actuators(spec: Any, description: RobotDescription) -> None:
    for number, (name, (gain, force)) in enumerate(zip(AXES, _DRIVE, strict=True)):
        axis = (0, 1, 5)[number]
        drive = spec.add_actuator(
            name=name,
            target="base",
            trntype=mujoco.mjtTrn.mjTRN_SITE,
            gear=np.eye(6)[axis],
            forcerange=(-force, force),
        )
        drive.set_to_velocity(kv=gain)
    arm = description.arm
    rows = zip(ARM, _STIFFNESS, arm.torque, _ranges(description), strict=True)
    for name, stiffness, torque, between in rows:
        servo = spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            actlimited=True,
            actrange=between,
            forcerange=(-torque, torque),
        )
        servo.set_to_intvelocity(kp=stiffness, kv=stiffness * arm.lag)
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=SIDES[0],
        name2=SIDES[1],
        data=(0.0, 1.0, *[0.0] * 10),
        solref=(0.005, 1.0),
    )
    width = spec.add_tendon(name="width")
    for side in SIDES:
        width.wrap_joint(side, 1.0)
    spec.add_actuator(
        name="fingers",
        target="width",
        trntype=mujoco.mjtTrn.mjTRN_TENDON,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=(_FINGER_STIFFNESS, *[0.0] * 9),
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=(0.0, -_FINGER_STIFFNESS, -_FINGER_DAMPING, *[0.0] * 7),
        forcerange=(-20.0, 20.0),
    )


def _object(spec: Any, name: str, obj: SimObject) -> None:
    body = _body(spec.worldbody, name, obj.pose)
    body.add_freejoint(name=name)
    total = sum(volume(part.shape) for part in obj.parts)
    for number, part in enumerate(obj.parts):
        geom = _add(spec, body, part, f"{name}/{number}", _Kind.OBJECT, _ALL, obj.friction)
        geom.mass = obj.mass * volume(part.shape) / total
        if not isinstance(part.shape, Box):
            geom.condim = 6  # it may roll


def _body(parent: Any, name: str, pose: SE3) -> Any:
    return parent.add_body(name=name, pos=pose.translation, quat=_quaternion(pose))


def _weigh(body: Any, inertia: Inertia) -> None:
    i = inertia.inertia
    body.explicitinertial = True
    body.mass, body.ipos = inertia.mass, inertia.lever
    body.fullinertia = (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])


def _add(
    spec: Any, body: Any, geom: Geom, name: str, kind: int, against: int, friction: float
) -> Any:
    """A shape on a body: what it is to others, and what it meets."""
    return body.add_geom(
        **_shape(spec, geom.shape, name),
        name=name,
        pos=geom.pose.translation,
        quat=_quaternion(geom.pose),
        contype=kind,
        conaffinity=against,
        condim=4,
        friction=(friction, _TORSION, _ROLLING),
        solref=_HARD,
        solimp=_SOLIMP,
        mass=0.0,
    )


def _shape(spec: Any, shape: Shape, name: str) -> dict[str, Any]:
    types = mujoco.mjtGeom
    match shape:
        case Box(half):
            return {"type": types.mjGEOM_BOX, "size": half}
        case Sphere(r):
            return {"type": types.mjGEOM_SPHERE, "size": (r, 0.0, 0.0)}
        case Cylinder(r, length):
            return {"type": types.mjGEOM_CYLINDER, "size": (r, length, 0.0)}
        case Capsule(r, length):
            return {"type": types.mjGEOM_CAPSULE, "size": (r, length, 0.0)}
        case Hull(vertices, triangles):
            spec.add_mesh(name=name, uservert=vertices.ravel(), userface=triangles.ravel())
            return {"type": types.mjGEOM_MESH, "meshname": name}
        case Plane():
            return {"type": types.mjGEOM_PLANE, "size": (0.0, 0.0, 1.0)}


def _half(geom: Geom) -> tuple[float, float, float]:
    assert isinstance(geom.shape, Box)
    return geom.shape.half


def _ranges(description: RobotDescription) -> list[tuple[float, float]]:
    limits = description.limits
    return list(zip(limits.q_min.tolist(), limits.q_max.tolist(), strict=True))


def _quaternion(pose: SE3) -> Array:
    x, y, z, w = Quaternion(pose.rotation).coeffs()
    return np.array([w, x, y, z])
