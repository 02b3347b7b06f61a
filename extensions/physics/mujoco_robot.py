"""MuJoCo specification of the robot: bodies, joints and motors."""

from math import isfinite
from typing import Any

import mujoco
import numpy as np
from pinocchio import SE3, Inertia

from extensions.physics.mujoco_shapes import ALL, Kind, add_body, add_geom, quaternion, weigh
from hw.sim import CAMERA, FINGERS, HAND, Member, members
from robots import Box, Geom, RobotDescription

SIDES = ("left", "right")
AXES = ("x", "y", "yaw")  # Joints of the base
FINGER_MOTOR = "fingers"  # Its actuator

_PADS = (-88000.0, -600.0)
"""Stiffness [1/s²] and damping [1/s] of the pads, negative for MuJoCo; with any partner. Friction
only takes away a velocity at this damping: an object carried round at ω creeps by about ω²r /
600 s. At 1000 a time step would let it shake."""
_SHELL = (0.014, 1.0)
"""Time constant [s] and damping ratio of all other shapes of the robot, whose covers yield; the
mean with those of the partner counts."""
_FRICTION = 0.3  # of all shapes; of two surfaces the rougher counts

_STIFFNESS, _STRONG = (1500.0, 4000.0), 50.0
"""Of the servos of the joints [Nm/rad], and the torque from which the second counts [Nm]."""
_STIFFNESS_OF_SLIDES = 1e5  # [N/m]
_ARMATURE, _DAMPING = 0.1, 0.5  # of each motor and gear [kg m²], [Nm s]

_DRIVE = ((20000.0, 500.0), (20000.0, 800.0), (3000.0, 250.0))
"""Of the base along x and y and about z: gain [N s/m, Nm s] and largest force [N, Nm]; along y only
the tyres of a differential drive hold."""

_FINGER_STIFFNESS, _FINGER_DAMPING = 8000.0, 80.0  # Of the gripper's servo [N/m, N s/m]
_FINGER_ARMATURE = 0.1  # [kg]


def arm_names(description: RobotDescription) -> list[str]:
    """Names of the joints of the arm."""
    return [f"joint{number}" for number in range(1, len(description.arm.joints) + 1)]


def add_robot(spec: Any, description: RobotDescription) -> None:
    """Add a robot to a specification, at its start but for its posture.

    Bodies are called `base`, `hand`, `left` and `right`, joints as in `AXES`, `arm_names` and
    `SIDES`, actuators like the joints, that of both fingers `fingers`. Names of geoms begin with
    their part.
    """
    base, arm, gripper = description.base, description.arm, description.gripper
    on_base = add_body(spec.worldbody, "base", SE3.Identity())
    for name, axis in zip(AXES, np.eye(3), strict=True):
        kind = mujoco.mjtJoint.mjJNT_HINGE if name == "yaw" else mujoco.mjtJoint.mjJNT_SLIDE
        on_base.add_joint(name=name, type=kind, axis=axis)
    on_base.add_site(name="base")
    box = Inertia.FromBox(base.mass, *base.size)
    raised = SE3(np.eye(3), np.array([0.0, 0.0, base.size[2] / 2.0]))
    weigh(on_base, raised.act(box) + description.bTa.act(arm.inertias[0]))
    # The frames of the members: base, foot, links, flange of the hand, end effector.
    frames = [(on_base, SE3.Identity()), (on_base, description.bTa)]
    names, slides = arm_names(description), arm.slides.tolist()
    for name, place, slide, inertia, between in zip(
        names, arm.joints, slides, arm.inertias[1:], _ranges(description), strict=True
    ):
        parent, below = frames[-1]
        link = add_body(parent, name, below * place)
        link.gravcomp = 1.0
        link.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_SLIDE if slide else mujoco.mjtJoint.mjJNT_HINGE,
            axis=(0.0, 0.0, 1.0),
            limited=between is not None,
            range=between or (0.0, 0.0),
            armature=_ARMATURE,
            damping=_DAMPING,
        )
        weigh(link, inertia)
        frames.append((link, SE3.Identity()))
    hand, fingers = _hand(frames[-1][0], arm.lTh, description)
    frames += [(hand, SE3.Identity()), (hand, gripper.hTe)]
    for number, member in enumerate(members(description)):
        body, place = frames[member.frame]
        if member.part == FINGERS:
            body, place = fingers[member.geom.name.split()[0]], SE3.Identity()
        against = ALL & ~Kind.FLOOR if member.frame == 0 else ALL  # the base stands there
        _add_member(spec, body, place, number, member, against, gripper.pad.name)
    _actuators(spec, description)


def add_hand(spec: Any, parent: Any, pTh: SE3, description: RobotDescription) -> None:
    """Add only the hand of a robot, with camera and fingers, to a body; see `add_robot`."""
    gripper = description.gripper
    hand, fingers = _hand(parent, pTh, description)
    for number, member in enumerate(members(description)):
        if member.part == FINGERS:
            body, place = fingers[member.geom.name.split()[0]], SE3.Identity()
        elif member.part in (HAND, CAMERA):
            body, place = hand, gripper.hTe
        else:
            continue
        _add_member(spec, body, place, number, member, ALL, gripper.pad.name)
    _finger_motor(spec)


def _hand(parent: Any, pTh: SE3, description: RobotDescription) -> tuple[Any, dict[str, Any]]:
    gripper, camera = description.gripper, description.camera
    hand = add_body(parent, "hand", pTh)
    hand.gravcomp = 1.0
    hand.add_site(name="tool", pos=gripper.hTe.translation, quat=quaternion(gripper.hTe))
    housing = Inertia.FromBox(camera.mass, *(2.0 * h for h in _half(camera.body)))
    hTc = gripper.hTe * camera.eTc * camera.body.pose
    weigh(hand, gripper.inertia + hTc.act(housing))
    return hand, {side: _finger(hand, side, description) for side in SIDES}


def _add_member(
    spec: Any, body: Any, place: SE3, number: int, member: Member, against: int, pad: str
) -> None:
    name, shape = f"{member.part}/{number}", member.geom.moved(place)
    geom = add_geom(spec, body, shape, name, 0, against, _FRICTION)
    geom.solref = _PADS if shape.name.endswith(pad) else _SHELL


def _finger(hand: Any, side: str, description: RobotDescription) -> Any:
    """A finger, in the end effector's axes; its joint is half of the width between the pads."""
    gripper = description.gripper
    body = add_body(hand, side, gripper.hTe)
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
    weigh(body, Inertia.FromBox(gripper.finger_mass, *lengths))
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
    stiff = np.where(arm.torque < _STRONG, *_STIFFNESS)
    stiff = np.where(arm.slides, _STIFFNESS_OF_SLIDES, stiff).tolist()
    rows = zip(arm_names(description), stiff, arm.torque, _ranges(description), strict=True)
    for name, stiffness, torque, between in rows:
        servo = spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            actlimited=between is not None,
            actrange=between or (0.0, 0.0),
            forcerange=(-torque, torque),
        )
        servo.set_to_intvelocity(kp=stiffness, kv=stiffness * arm.lag)
    _finger_motor(spec)


def _finger_motor(spec: Any) -> None:
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
        name=FINGER_MOTOR,
        target="width",
        trntype=mujoco.mjtTrn.mjTRN_TENDON,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=(_FINGER_STIFFNESS, *[0.0] * 9),
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        biasprm=(0.0, -_FINGER_STIFFNESS, -_FINGER_DAMPING, *[0.0] * 7),
        forcerange=(-20.0, 20.0),
    )


def _half(geom: Geom) -> tuple[float, float, float]:
    assert isinstance(geom.shape, Box)
    return geom.shape.half


def _ranges(description: RobotDescription) -> list[tuple[float, float] | None]:
    """Of every joint of the arm; None if it is continuous."""
    limits = description.limits
    between = zip(limits.q_min.tolist(), limits.q_max.tolist(), strict=True)
    return [(low, high) if isfinite(low) else None for low, high in between]
