"""A hand without an arm in MuJoCo's specification of a model: it is led from above, and yields."""

from __future__ import annotations

from math import sqrt
from typing import Any

import mujoco
import numpy as np
from pinocchio import SE3, Inertia

from hw.sim.physics.robot import add_hand
from hw.sim.physics.shapes import add_body, weigh
from robots import RobotDescription

CARRIER = ("x", "y", "z", "yaw")
"""Joints, and the motors of them, that lead the hand along and about the axes of the world."""
DOWN = SE3(np.diag([1.0, -1.0, -1.0]), np.zeros(3))
"""The end effector on its carrier: it points down."""

_MASS, _TURNING = 4.0, 0.05  # Of the arm that would be behind it, as felt at the tool [kg, kg m²]
_STIFFNESS, _TURNING_STIFFNESS = 16000.0, 200.0
"""Of the servos: those of the arm's joints at half a metre [N/m, Nm/rad]."""
_FORCE, _TORQUE = 150.0, 12.0  # Largest ones of the servos [N, Nm]


def add_floating_hand(spec: Any, description: RobotDescription) -> None:
    """Add the hand of a robot, pointing down, its end effector at the origin.

    Joints and actuators are called as in `CARRIER`; those of the fingers as in `add_robot`.
    """
    carrier = add_body(spec.worldbody, "carrier", SE3.Identity())
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
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcerange=(-force, force),
        )
        servo.set_to_position(kp=stiffness, kv=2.0 * sqrt(stiffness * mass))
    add_hand(spec, carrier, DOWN * description.gripper.hTe.inverse(), description)
