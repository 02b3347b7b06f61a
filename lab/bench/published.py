"""The step of the published example, computed by roboticstoolbox-python, as a reference.

Release 1.5.0 of the toolbox no longer contains the Frankie of the paper; it is built here from the
description that is still included. The published example for the omnidirectional robot puts ε of
eq. 13 on the wrong degree of freedom of the base; here it is on the rotation.
"""

from __future__ import annotations

from importlib import import_module
from math import atan2
from typing import Any

import numpy as np
from pinocchio import SE3

from config import UserError
from controller import Array

_EFFORT = 0.01
"""k_a, and the cost of base motion times |e|."""
_GAIN, _ROTATION_FACTOR = 1.5, 1.3
"""β, and the factor of the rotation."""
_STOP, _INFLUENCE = 0.1, 0.9
"""ρ_s and ρ_i of the dampers [rad]."""
_HEADING_GAIN = 0.5
"""k_ε."""
_SLACK = 10.0
"""Bound of the slack [m/s and rad/s]."""
_FRANKIE = "qut_frankie_description/robots/frankie_arm_hand.urdf.xacro"
_BASE_SPEED = 4.0
_ARM_SPEEDS = (2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61)


class ToolboxError(UserError):
    """The toolbox or a package that it needs is not installed."""


class PublishedStep:
    """The QP of the paper as its published example builds it, solved once per call.

    Args:
        name: frankie or omni.

    Raises:
        ToolboxError: roboticstoolbox-python, qpsolvers or quadprog is not installed.
    """

    def __init__(self, name: str) -> None:
        try:
            toolbox = import_module("roboticstoolbox")
            self._solve_qp = import_module("qpsolvers").solve_qp
            import_module("quadprog")
        except ImportError as error:
            raise ToolboxError(
                f"--vs rtb needs packages that are not installed ({error.name}): "
                "pip install roboticstoolbox-python qpsolvers quadprog"
            ) from None
        self._p_servo = toolbox.p_servo
        self._robot = _frankie() if name == "frankie" else toolbox.models.FrankieOmni()
        self._robot.grippers[0].tool = toolbox.ET.tz(0.1034).A()
        self._n_base = 2 if name == "frankie" else 3
        self._turn = 0 if name == "frankie" else 2
        self._first_arm_link = next(
            link for link in self._robot.links if link.name == "panda_link0"
        )
        self._speeds = np.array([_BASE_SPEED] * self._n_base + list(_ARM_SPEEDS))

    def cache_limits(self) -> None:
        """Keep the joint limits, which the toolbox otherwise collects again at every access."""
        kind = type(self._robot)
        self._robot.__class__ = type("Cached", (kind,), {"qlim": self._robot.qlim})

    def __call__(self, wTb: SE3, q: Array, goal: SE3) -> Array:
        """Velocities (n,) before the example scales them, in the toolbox's order, base first.

        Args:
            wTb: base pose.
            q: (7,) joint positions [rad].
            goal: desired pose of the tool in the world.
        """
        robot, n_base = self._robot, self._n_base
        n = n_base + len(q)
        robot._T = wTb.homogeneous
        joints = np.concatenate([np.zeros(n_base), q])
        wTe = robot.fkine(joints).A
        target = goal.homogeneous
        error = np.abs((np.linalg.inv(wTe) @ target)[:3, 3]).sum()

        Q = np.eye(n + 6)
        Q[:n, :n] *= _EFFORT
        Q[:n_base, :n_base] /= error
        Q[n:, n:] /= error
        twist, _ = self._p_servo(wTe, target, _GAIN)
        twist[3:] *= _ROTATION_FACTOR
        A_eq = np.hstack([robot.jacobe(joints), np.eye(6)])
        A_in, b_in = np.zeros((n + 6, n + 6)), np.zeros(n + 6)
        A_in[:n, :n], b_in[:n] = robot.joint_velocity_damper(q=joints, ps=_STOP, pi=_INFLUENCE, n=n)
        c = np.zeros(n + 6)
        c[n_base:n] = -robot.jacobm(joints, start=self._first_arm_link).reshape(-1)
        x, y = robot.fkine(joints, include_base=False).A[:2, 3]
        c[self._turn] = -_HEADING_GAIN * atan2(y, x)
        bound = np.concatenate([self._speeds, np.full(6, _SLACK)])
        solution = self._solve_qp(
            Q, c, A_in, b_in, A_eq, twist, lb=-bound, ub=bound, solver="quadprog"
        )
        return np.full(n, np.nan) if solution is None else np.asarray(solution[:n])


def _frankie() -> Any:
    reader = import_module("roboticstoolbox.models.URDF.URDFRobot")
    links, _, _ = reader.URDF_read(_FRANKIE)
    hand = next(link for link in links if link.name == "frankie_hand")
    robot = import_module("roboticstoolbox.robot.Robot").Robot
    return robot(links, name="Frankie", gripper_links=hand)
