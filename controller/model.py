"""The kinematics of Frankie and Omni-Frankie: one Pinocchio arm on a base, and what both may do.

The arm's numbers are those of the Franka Emika Robot's published description. The base is planar,
so its columns of the Jacobian are written down instead of computed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from controller.command import N_ARM, Array, Command

_ARM_JOINTS = (
    # translation to the next joint [m], turn about x [quarter turns]
    ((0.0, 0.0, 0.333), 0),
    ((0.0, 0.0, 0.0), -1),
    ((0.0, -0.316, 0.0), 1),
    ((0.0825, 0.0, 0.0), 1),
    ((-0.0825, 0.384, 0.0), -1),
    ((0.0, 0.0, 0.0), 1),
    ((0.088, 0.0, 0.0), 1),
)
_LINK7_TO_HAND = SE3(pin.utils.rotate("z", -pi / 4.0), np.array([0.0, 0.0, 0.107]))
HAND_TO_TOOL = SE3(np.eye(3), np.array([0.0, 0.0, 0.1034]))
"""Flange of the hand to the grasp centre between the finger tips."""

_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]

READY = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 2.0, pi / 4.0])
"""(7,) the arm's ready posture [rad]: hand in front, pointing down."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Limits:
    """What the robot may do; the defaults are the arm's data sheet and a careful base."""

    q_min: Array
    """(7,) lower joint positions [rad]."""
    q_max: Array
    """(7,) upper joint positions [rad]."""
    qd: Array
    """(7,) joint speeds [rad/s]."""
    qdd: Array
    """(7,) joint accelerations [rad/s^2]."""
    base_twist: Array
    """(3,) base speeds along x, y and about z [m/s, m/s, rad/s]."""
    base_acceleration: Array
    """(3,) base accelerations along x, y and about z [m/s^2, m/s^2, rad/s^2]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotDescription:
    """The numbers that tell one robot from another."""

    name: str
    base_axes: Array
    """(3, n_base) how the base's degrees of freedom make up its twist."""
    bTa: SE3
    """Arm's foot in the base frame."""
    limits: Limits


def _limits(base_twist: tuple[float, float, float]) -> Limits:
    return Limits(
        q_min=np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]),
        q_max=np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]),
        qd=np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]),
        qdd=np.array([6.0, 6.0, 6.0, 6.0, 6.0, 6.0, 6.0]),
        base_twist=np.array(base_twist),
        base_acceleration=np.array([1.5, 1.5, 3.0]),
    )


FRANKIE = RobotDescription(
    name="frankie",
    base_axes=np.array([[0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]),
    bTa=SE3(np.eye(3), np.array([0.15, 0.0, 0.38])),
    limits=_limits((1.0, 0.0, 1.05)),
)
"""Differential drive; degrees of freedom (ω, v), as in the paper."""

OMNI = RobotDescription(
    name="omni",
    base_axes=np.eye(3),
    bTa=SE3(np.eye(3), np.array([0.0, 0.0, 0.28])),
    limits=_limits((1.0, 1.0, 1.05)),
)
"""Holonomic base; degrees of freedom (vx, vy, ω)."""

ROBOTS = {robot.name: robot for robot in (FRANKIE, OMNI)}
"""The robots by name."""


def _arm_model(bTa: SE3) -> pin.Model:
    arm = pin.Model()
    joint = 0
    for index, (translation, quarter_turns) in enumerate(_ARM_JOINTS):
        placement = SE3(pin.utils.rotate("x", quarter_turns * pi / 2.0), np.array(translation))
        parent = bTa if index == 0 else SE3.Identity()
        joint = arm.addJoint(joint, pin.JointModelRZ(), parent * placement, f"joint{index + 1}")
    tool = pin.Frame("tool", joint, 0, _LINK7_TO_HAND * HAND_TO_TOOL, pin.FrameType.OP_FRAME)
    arm.addFrame(tool)
    return arm


class RobotModel:
    """Forward kinematics, Jacobian and manipulability of a mobile manipulator.

    Not to be shared between threads: Pinocchio's workspace is reused from call to call.

    Args:
        description: which robot.
    """

    def __init__(self, description: RobotDescription = FRANKIE) -> None:
        self.description = description
        self.name = description.name
        self.limits = description.limits
        self.n_base = description.base_axes.shape[1]
        self.n = self.n_base + N_ARM
        axes, limits = description.base_axes, description.limits
        self.speed_limits = np.concatenate([axes.T @ limits.base_twist, limits.qd])
        """(n,) largest speed of every degree of freedom, base first."""
        self.acceleration_limits = np.concatenate([axes.T @ limits.base_acceleration, limits.qdd])
        """(n,) largest acceleration of every degree of freedom, base first."""
        self.base_turn = axes[2]
        """(n_base,) how much every degree of freedom of the base turns it."""
        self._arm = _arm_model(description.bTa)
        self._data = self._arm.createData()
        self._tool = self._arm.getFrameId("tool")

    def command(self, velocities: Array) -> Command:
        """The command for velocities (n,) of all degrees of freedom, base first."""
        base = self.description.base_axes @ velocities[: self.n_base]
        return Command(base_twist=base, qd=velocities[self.n_base :].copy())

    def velocities(self, command: Command) -> Array:
        """(n,) velocities of all degrees of freedom, base first: the inverse of `command`."""
        return np.concatenate([self.description.base_axes.T @ command.base_twist, command.qd])

    def bTe(self, q: Array) -> SE3:
        """End effector in the base, for joint positions q (7,) [rad]."""
        pin.framesForwardKinematics(self._arm, self._data, q)
        return self._data.oMf[self._tool].copy()

    def wTe(self, wTb: SE3, q: Array) -> SE3:
        """End effector in the world, for a base pose and joint positions q (7,) [rad]."""
        return wTb * self.bTe(q)

    def link_poses(self, wTb: SE3, q: Array) -> tuple[SE3, ...]:
        """The arm's foot, its seven links and the hand in the world: 9 poses, for q (7,) [rad]."""
        pin.forwardKinematics(self._arm, self._data, q)
        links = [wTb * self._data.oMi[joint] for joint in range(1, N_ARM + 1)]
        return (wTb * self.description.bTa, *links, links[-1] * _LINK7_TO_HAND)

    def arm_jacobian(self, q: Array) -> tuple[SE3, Array]:
        """Where the end effector is and how the joints move it.

        Args:
            q: (7,) joint positions [rad].

        Returns:
            bTe and the (6, 7) Jacobian at the end effector, linear first, in base axes.
        """
        J = pin.computeFrameJacobian(
            self._arm, self._data, q, self._tool, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        pin.updateFramePlacement(self._arm, self._data, self._tool)
        return self._data.oMf[self._tool].copy(), J

    def jacobian(self, q: Array) -> tuple[SE3, Array]:
        """Where the end effector is and how base and joints move it (Haviland 2022, eq. 5).

        Args:
            q: (7,) joint positions [rad].

        Returns:
            bTe and the (6, n) Jacobian at the end effector, linear first, in base axes; the first
            `n_base` columns are the base's degrees of freedom.
        """
        bTe, J_arm = self.arm_jacobian(q)
        x, y = bTe.translation[:2]
        twist_of_base = np.array(
            [[1, 0, -y], [0, 1, x], [0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 1]], dtype=float
        )
        return bTe, np.hstack([twist_of_base @ self.description.base_axes, J_arm])


def robot_model(name: str) -> RobotModel:
    """The model of the robot called `name`.

    Raises:
        KeyError: there is no such robot; `ROBOTS` has the names.
    """
    return RobotModel(ROBOTS[name])


def manipulability(J: Array) -> tuple[float, Array]:
    """Yoshikawa's manipulability m = sqrt(det(J Jᵀ)) of an arm and its gradient.

    The gradient is Haviland 2022, eq. 10 (J_m), with the Hessian of a serial chain of revolute
    joints written as cross products of Jacobian columns, so that it costs O(n):
    ∂J_i/∂q_k = (ω_k × v_i, ω_k × ω_i) for k <= i and (ω_i × v_k, 0) for k > i.

    Args:
        J: (6, 7) Jacobian, linear first, in any fixed axes.

    Returns:
        m and its gradient (7,) [1/rad]; the gradient is zero where the arm is singular.
    """
    A = J @ J.T
    m = float(np.sqrt(max(np.linalg.det(A), 0.0)))
    if m < 1e-9:
        return m, np.zeros(J.shape[1])
    B = np.asarray(np.linalg.solve(A, J), dtype=np.float64)
    v, w, b, c = J[:3], J[3:], B[:3], B[3:]
    later = _cross(v, b) + _cross(w, c)
    earlier = _cross(b, w)
    from_later = np.cumsum(later[:, ::-1], axis=1)[:, ::-1]
    from_earlier = np.cumsum(earlier, axis=1) - earlier
    return m, m * (w * from_later + v * from_earlier).sum(axis=0)


def _cross(a: Array, b: Array) -> Array:
    """Cross products of the columns of two (3, n) arrays; numpy's own takes ten times as long."""
    return a[_NEXT] * b[_AFTER] - a[_AFTER] * b[_NEXT]
